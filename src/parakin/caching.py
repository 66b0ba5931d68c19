"""Properties worked out once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

T = TypeVar("T")


class cached_property(Generic[T]):  # noqa: N801  # as that of functools
    """As that of functools, without the lock that it has in Python 3.11: a process forked while
    another thread holds it would wait for it for ever. Two threads may both work a value out.
    """

    def __init__(self, work_out: Callable[[Any], T]) -> None:
        self._work_out, self.__doc__ = work_out, work_out.__doc__
        self._name = work_out.__name__

    @overload
    def __get__(self, owner: None, kind: type) -> cached_property[T]: ...
    @overload
    def __get__(self, owner: object, kind: type) -> T: ...
    def __get__(self, owner: object | None, kind: type) -> T | cached_property[T]:
        if owner is None:
            return self
        value = self._work_out(owner)
        return owner.__dict__.setdefault(self._name, value)  # type: ignore[no-any-return]
