"""Which version of which store an object means, for other processes."""

import os
import weakref
from typing import Any, NamedTuple

from .errors import BadState

_shared: "weakref.WeakValueDictionary[Any, Any]" = weakref.WeakValueDictionary()  # what pickles opened in this process


class Identity(NamedTuple):
    """A version of a store. The path is absolute: another process has its own working directory."""

    path: str
    uuid: str
    sequence: int
    memory: int


def opened(identity):
    """Opens this version, or refuses."""
    from .store import open_store
    store = open_store(identity.path, memory=identity.memory)
    found = store.info
    if (found.uuid, found.sequence) != (identity.uuid, identity.sequence):
        store.close()
        other = (f"version {found.sequence}" if found.uuid == identity.uuid
                 else f"version {found.sequence} of another store, {found.uuid}")
        raise BadState(f"open {identity.path}: expected version {identity.sequence} of the store "
                       f"{identity.uuid}, as it was pickled, found {other}", identity.path)
    return store


def shared(identity):
    """The same, one for all levels of this process: opening takes time and memory."""
    key = (os.getpid(), identity)
    store = _shared.get(key)
    if store is None:
        store = _shared[key] = opened(identity)
    return store
