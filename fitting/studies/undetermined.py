"""What an image does not determine, in words: directions in which numbers may change together without being seen."""

import numpy as np
from jaxtyping import Bool, Float

from fitting.reasons import Reason
from newtonjax.numerics import Statement

# What couples numbers that are undetermined together, parts of a combination that are named, and how near an exponent
# is to a half of a whole number.
_COUPLED, _PART, _NEAR = 1e-3, 0.05, 0.03


def in_words(
    names: list[str],
    ratio: Bool[np.ndarray, " n"],
    relative: Float[np.ndarray, " n"],
    axes: Float[np.ndarray, "n weak"],
) -> list[Statement]:
    """A sentence for each group of numbers that are undetermined together.

    `axes`: orthonormal directions in which nothing is seen; `relative`: the step of each number in them, over its size
    where only ratios count (`ratio`), else over its scale.
    """
    projector = axes @ axes.T
    sentences = []
    for group in _groups(np.abs(projector) > _COUPLED):
        size, within = np.linalg.eigh(projector[np.ix_(group, group)])
        directions = within[:, size > 0.5] * relative[group][:, None]
        sentences.append(_in_group([names[k] for k in group], ratio[group], directions))
    return sentences


def _groups(coupled: np.ndarray) -> list[np.ndarray]:
    """Indices that are coupled with each other, by group; those coupled with nothing, themselves too, are left out."""
    from scipy.sparse.csgraph import connected_components

    members = np.flatnonzero(coupled.any(axis=1))
    _, label = connected_components(coupled[np.ix_(members, members)], directed=False)
    return [members[label == k] for k in np.unique(label)]


def _in_group(names: list[str], ratio: np.ndarray, directions: Float[np.ndarray, "n weak"]) -> Statement:
    """What is measured of numbers that are undetermined in some directions, where it is one product; else those."""
    together = " and ".join(text for text in (", ".join(names[:-1]), names[-1]) if text)
    if len(names) - directions.shape[1] == 1 and ratio.all():
        product = _product(names, np.linalg.svd(directions.T)[2][-1])
        return Reason.ONLY_PRODUCT_MEASURED(together=together, product=product)
    columns = [column / np.abs(column).max() for column in directions.T]
    unseen = " or ".join(
        ", ".join(
            f"{value:+.3g}{' %' if ratio[k] else ' hundredths'} of {names[k]}"
            for k, value in enumerate(column)
            if abs(value) > _PART
        )
        for column in columns
    )
    return Reason.UNSEEN_CHANGES(together=together, changes=unseen)


def _product(names: list[str], exponents: np.ndarray) -> str:
    exponents = exponents / np.abs(exponents).min() if np.abs(exponents).min() > 0 else exponents
    exponents = exponents * np.sign(exponents[np.argmax(np.abs(exponents))])
    nearest = np.round(2 * exponents) / 2
    exponents = np.where(np.abs(exponents - nearest) < _NEAR, nearest, exponents)
    power = dict(zip(names, exponents, strict=True))

    def written(sign: int) -> str:
        return " ".join(n if abs(v) == 1 else f"{n}^{abs(v):.3g}" for n, v in power.items() if v * sign > 0)

    above, below = written(1), written(-1)
    if not below:
        return above
    return f"{above} / ({below})" if " " in below else f"{above} / {below}"
