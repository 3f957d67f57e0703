"""Uncertainty of a least-squares fit whose residuals are not white: sensors quantise, and are calibrated to a point."""

import numpy as np


def long_run_length(residuals: list[np.ndarray]) -> int:
    """Samples over which residuals remember: the first lag at which no series is correlated by more than its noise.

    `residuals` are evenly sampled series of one kind each; at most a tenth of the shortest.
    """
    longest = 1
    for series in residuals:
        values = np.nan_to_num(series - np.nanmean(series))
        size = values.size
        most = max(size // 10, 1)
        spectrum = np.abs(np.fft.rfft(values, 2 * size)) ** 2
        correlation = np.fft.irfft(spectrum)[:size]
        if correlation[0] <= 0.0:
            continue
        correlation = correlation / correlation[0]
        below = np.flatnonzero(correlation[: most + 1] < 2.0 / np.sqrt(size))
        longest = max(longest, int(below[0]) if below.size else most)
    return longest


def long_run_deviation(series: np.ndarray, length: int) -> float:
    """Standard deviation of a white noise whose means over `length` samples scatter as those of `series`."""
    values = np.nan_to_num(series - np.nanmean(series))
    sums = np.diff(np.concatenate([[0.0], np.cumsum(values)])[:: max(length, 1)])
    return float(max(np.std(sums) / np.sqrt(length), np.std(values)))


def at_least(cov: np.ndarray, floor: np.ndarray) -> np.ndarray:
    """`cov` with each variance raised to that of `floor` where it is less; correlations stay."""
    own, other = np.diag(cov), np.diag(floor)
    scale = np.sqrt(np.maximum(np.divide(other, own, out=np.ones_like(own), where=own > 0.0), 1.0))
    return np.asarray(cov * np.outer(scale, scale))


def inverse(normal: np.ndarray) -> np.ndarray:
    """Of the normal equations' matrix, in units of its own unknowns: one that is known a million times worse than
    another is no zero.
    """
    scale = np.sqrt(np.diag(normal))
    scale[scale == 0.0] = 1.0
    both = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(normal / both, hermitian=True) / both)


def sandwich(
    jacobian: np.ndarray, residuals: np.ndarray, groups: list[slice], length: int, priors: np.ndarray
) -> np.ndarray:
    """Covariance H^-1 S H^-1 of a weighted least-squares estimate with priors of unit standard deviation.

        H = J'J + diag(priors),   S = sum over groups of sum_k sum_l w(l) s_k s_{k+l}' + diag(priors),   s_k = J_k' r_k

    with Bartlett weights w over `length` samples (Newey and West 1987).

    Args:
        jacobian: of the weighted residuals, shape (samples, unknowns).
        residuals: weighted, shape (samples,).
        groups: samples that follow one another in time; between groups there is no correlation.
        length: samples over which residuals remember.
        priors: 1 for an unknown with a prior of unit standard deviation, else 0, shape (unknowns,).
    """
    curved = inverse(jacobian.T @ jacobian + np.diag(priors))
    meat = np.diag(priors).astype(float)
    for group in groups:
        scores = jacobian[group] * residuals[group, None]
        padded = np.vstack([np.zeros((1, scores.shape[1])), np.cumsum(scores, axis=0)])
        full = np.vstack([np.zeros((length - 1, scores.shape[1])), padded, np.repeat(padded[-1:], length - 1, axis=0)])
        windows = full[length:] - full[:-length]
        meat += windows.T @ windows / length
    return np.asarray(curved @ meat @ curved)
