"""The way from one shape to another, written out: animations, sequences, pictures."""

from henkei.morph.write import write_morph

__all__ = ["write_morph"]
