"""The laws that a model file may name: those of this folder, and one's own."""

from __future__ import annotations

from types import MappingProxyType

from simulate.control.eddy_damper import EddyDamper
from simulate.control.mechanical_link import MechanicalLink
from simulate.control.one_way import OneWay
from simulate.control.profile import Profile
from simulate.control.synchronise import Synchronise
from simulate.model.control import Controller, Laws, require_law

_LAWS: dict[str, type[Controller]] = {kind.law: kind for kind in (Synchronise, Profile, OneWay, EddyDamper, MechanicalLink)}


def known_laws() -> Laws:
    """The laws by name."""
    return MappingProxyType(_LAWS)


def add_law(kind: type[Controller]) -> type[Controller]:
    """Add a law of one's own; the law that has its name, which is another where that was taken."""
    return _LAWS.setdefault(require_law(kind).law, kind)
