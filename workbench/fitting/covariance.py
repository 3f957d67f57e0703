"""Uncertainty of a least-squares fit: residuals are not white, models lack something, and what is held is not known
exactly.
"""

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


def by_blocks(jacobian: np.ndarray, residuals: np.ndarray, blocks: np.ndarray, priors: np.ndarray) -> np.ndarray:
    """Covariance of the same estimate from how far it moves when a part of the record is left out (jackknife).

        d_b = -(H - J_b'J_b)^-1 J_b' r_b,   cov = (B - 1)/B sum_b (d_b - mean d)(d_b - mean d)'

    to first order. What a model lacks stays in the residual over a whole motion, and a part of the record then wants
    other numbers than the next: no memory of a few samples shows that.

    Args:
        jacobian: of the weighted residuals, shape (samples, unknowns).
        residuals: weighted, shape (samples,).
        blocks: the number of the part of the record to which each sample belongs, shape (samples,); -1 to none.
        priors: 1 for an unknown with a prior of unit standard deviation, else 0, shape (unknowns,).
    """
    normal = jacobian.T @ jacobian + np.diag(priors)
    moved = []
    for block in range(int(np.max(blocks)) + 1):
        own = blocks == block
        part = jacobian[own]
        moved.append(inverse(normal - part.T @ part) @ (part.T @ residuals[own]))
    if len(moved) < 2:
        return np.zeros_like(normal)
    away = np.array(moved) - np.mean(moved, axis=0)
    return np.asarray(away.T @ away * (len(moved) - 1) / len(moved))


def of_uncertain(jacobian: np.ndarray, held: np.ndarray, deviations: np.ndarray, priors: np.ndarray) -> np.ndarray:
    """What parameters that are held, and known to a standard deviation, add to the covariance of those that are fitted.

        dx/dp = -H^-1 J' dr/dp,   H = J'J + diag(priors),   cov = sum_p (dx/dp)(dx/dp)' std_p^2

    Args:
        jacobian: dr/dx of the weighted residuals r by the fitted unknowns x, shape (samples, unknowns).
        held: dr/dp of the same residuals by the held parameters p, shape (samples, held).
        deviations: std_p, in the units of p, shape (held,).
        priors: 1 for an unknown with a prior of unit standard deviation, else 0, shape (unknowns,).
    """
    normal = jacobian.T @ jacobian + np.diag(priors)
    moved = inverse(normal) @ (jacobian.T @ (held * deviations))
    return np.asarray(moved @ moved.T)
