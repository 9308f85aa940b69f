"""What a key of numpy picks from an array whose records are not in memory."""

import operator

import numpy as np

from . import _records


def _is_truth(each):
    return isinstance(each, (bool, np.bool_)) or (
        isinstance(each, np.ndarray) and each.ndim == 0 and each.dtype == bool)


def _array_of(each):
    """A list as numpy takes it: an empty one has whole numbers. What a masked array hides picks nothing
    and leaves nothing out, so it is refused."""
    array = _records.unmasked("key", each)
    if array.size == 0 and not isinstance(each, np.ndarray):
        return array.astype(np.intp)
    if array.dtype != bool and array.dtype.kind not in "iu":
        raise IndexError(f"expected whole numbers, slices or a mask, found {array.dtype}")
    return array


def _element(each):
    """One element of a key: None, Ellipsis, a slice, an int or an array."""
    if each is None or each is Ellipsis or isinstance(each, slice):
        return each
    if _is_truth(each):
        raise IndexError(f"a single {bool(each)} is no key: expected numbers, slices, lists or a "
                         "mask of all vertices")
    if isinstance(each, np.ndarray):
        return _array_of(each)
    try:
        return operator.index(each)
    except TypeError:
        return _array_of(each)


def _taken(each):
    """How many dimensions an element takes."""
    if each is None or each is Ellipsis:
        return 0
    return each.ndim if isinstance(each, np.ndarray) and each.dtype == bool else 1


def elements(key, ndim):
    """The key as a list of elements that take all `ndim` dimensions, and the place of the one that
    takes the first."""
    parts = [_element(each) for each in (key if isinstance(key, tuple) else (key,))]
    taken = sum(map(_taken, parts))
    if taken > ndim:
        raise IndexError(f"too many indices: expected at most {ndim}, found {taken}")
    dots = [place for place, each in enumerate(parts) if each is Ellipsis]
    if len(dots) > 1:
        raise IndexError("an index can only have a single ellipsis ('...')")
    rest = [slice(None)] * (ndim - taken)
    if not dots:
        parts += rest
    elif rest:
        parts[dots[0]:dots[0] + 1] = rest
    return parts, next(place for place, each in enumerate(parts) if _taken(each))


def checked(numbers, count):
    """Numbers of vertices, from 0 on: negative ones count from the end."""
    low, high = (int(numbers.min()), int(numbers.max())) if numbers.size else (0, 0)
    if numbers.size and (low < -count or high >= count):
        raise IndexError(f"vertex {low if low < -count else high}: expected -{count} to {count - 1}")
    return numbers.astype(np.int64) % max(count, 1)


def masked(mask, shape):
    """The vertices of which a mask picks anything."""
    if mask.shape != shape[:mask.ndim]:
        raise IndexError(f"mask: expected shape {shape[:mask.ndim]}, found {mask.shape}")
    return np.flatnonzero(mask if mask.ndim == 1 else mask.any(axis=1))
