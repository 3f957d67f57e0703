"""Gain files: what is written is read again."""

from pathlib import Path

from workbench.toml.gain_file import Entry, GainFile, MarginsTable, gain_file_text, read_gain_file


def test_a_gain_file_that_is_written_is_read_again(tmp_path: Path) -> None:
    """Whole numbers, text, what is infinite, names in any letters; a margin and a rotation that there are not."""
    content = GainFile(
        title='"p", tuned',
        source="Ångström",
        type="pid",
        at=[
            Entry(
                rpm=25.0,
                settings={"kp": "500 V/m", "feedforward": 1, "lead": 7e-5},
                objective={"value": 0.5, "weights": {"rms_error": 1.0}},
                margins=MarginsTable(phase_margin_deg=45.5, speed="30 mm/s"),
                search={"seeds": [1, 2], "objective_of_each": [0.5, float("inf")]},
            ),
            Entry(
                rpm=60.0,
                settings={"kp": "400 V/m"},
                rotation={"rpm": "60 rpm"},
                objective={},
                margins=MarginsTable(speed="1 mm/s"),
                search={},
            ),
        ],
    )
    path = tmp_path / "p.toml"
    path.write_text(gain_file_text(content), encoding="utf-8")
    assert read_gain_file(path) == content
    text = path.read_text(encoding="utf-8")
    assert "feedforward = 1\n" in text
    assert "[at.rotation]" in text
    assert text.count("[at.rotation]") == 1
    assert "gain_margin_dB" not in text


def test_a_file_by_hand_needs_type_and_settings_alone(tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    path.write_text('type = "pid"\n[[at]]\nsettings = { kp = "500 V/m" }\n', encoding="utf-8")
    read = read_gain_file(path)
    assert (read.type, read.at[0].settings, read.at[0].margins) == ("pid", {"kp": "500 V/m"}, None)
    assert gain_file_text(read).startswith('type = "pid"')
