"""Numbers that a program gives, as the dtype of an attribute."""

import numpy as np

from .errors import InvalidArgument


def type_name(dtype, known):
    """The name of a dtype that is one of `known`."""
    try:
        name = np.dtype(dtype).newbyteorder("<").str
    except TypeError:
        name = repr(dtype)
    if name not in known:
        raise InvalidArgument(f"dtype: expected one of {', '.join(known)}, found {name}")
    return name


def unmasked(what, records):
    """The numbers as an array. Those that a masked array hides have no place in a store."""
    hidden = np.ma.count_masked(records) if isinstance(records, np.ma.MaskedArray) else 0
    if hidden:
        raise InvalidArgument(f"{what}: expected a number everywhere, found {hidden} that are masked; "
                              "array.filled(number) puts a number there")
    return np.asarray(records)


def rounded(given, floats):
    """Where these numbers, which are `given` as floats, are others: where a whole number has more digits
    than the type, or a long double has."""
    wide = np.longdouble
    return floats.astype(wide) != given.astype(wide)


def positions(what, given):
    """The numbers as float64, and in how many rows that rounds one."""
    given = unmasked(what, given)
    if given.dtype.kind not in "iufO":
        raise InvalidArgument(f"{what}: expected numbers, found {given.dtype}")
    floats = np.ascontiguousarray(given, np.float64)
    if given.dtype.kind == "O" or given.dtype.itemsize < 8 or given.dtype == np.float64:
        return floats, 0
    changed = rounded(given, floats) & ~np.isnan(floats)
    return floats, int(changed.reshape(len(floats), -1).any(1).sum()) if floats.ndim else 0


def fitted(what, records, dtype):
    """The records as this dtype, if that loses no kind of number: float64 may become float32, but 1.5
    no integer; and a whole number that the dtype does not have is refused."""
    given = unmasked(what, records)
    if given.dtype == dtype:
        return given
    whole = given.dtype.kind in "iu" and dtype.kind in "iu"
    if not whole and not np.can_cast(given.dtype, dtype, "same_kind"):
        raise InvalidArgument(f"{what}: expected {dtype}, found {given.dtype}")
    if whole and given.size:
        allowed, low, high = np.iinfo(dtype), int(given.min()), int(given.max())
        if low < allowed.min or high > allowed.max:
            raise InvalidArgument(f"{what}: expected {allowed.min} to {allowed.max} ({dtype}), found "
                                  f"{low if low < allowed.min else high}")
    try:
        with np.errstate(over="raise"):
            result = given.astype(dtype)
        changed = rounded(given, result) if given.dtype.kind in "iu" and dtype.kind == "f" else None
        if changed is not None and changed.any():
            raise InvalidArgument(f"{what}: expected whole numbers that {dtype} has, found "
                                  f"{given[changed][0]} and {changed.sum() - 1} others that it rounds: "
                                  "float64 has all up to 2^53, int64 all of them")
        return result
    except FloatingPointError:
        raise InvalidArgument(f"{what}: a number is too large for {dtype}") from None
