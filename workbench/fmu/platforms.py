"""FMI's names of the platforms on which binaries are made and loaded here."""

import platform

PLATFORMS = {
    ("Linux", "x86_64"): {2: "linux64", 3: "x86_64-linux"},
    ("Linux", "aarch64"): {2: "aarch64-linux", 3: "aarch64-linux"},
    ("Darwin", "x86_64"): {2: "darwin64", 3: "x86_64-darwin"},
    ("Darwin", "arm64"): {2: "aarch64-darwin", 3: "aarch64-darwin"},
}
"""By version of FMI."""

SUFFIX = {"Linux": ".so", "Darwin": ".dylib"}


def platform_here() -> str:
    """This platform in words."""
    return f"{platform.system()} {platform.machine()}"


def is_known() -> bool:
    """Whether FMI has a name for this platform."""
    return (platform.system(), platform.machine()) in PLATFORMS


def binary_place(fmi: int, identifier: str) -> str:
    """Where the binary of a known platform lies in an FMU."""
    folder = PLATFORMS[platform.system(), platform.machine()][fmi]
    return f"binaries/{folder}/{identifier}{SUFFIX[platform.system()]}"
