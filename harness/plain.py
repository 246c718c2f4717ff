"""Texts of others, such as names of cases, without what would steer a terminal."""


def plain(text: str) -> str:
    """Return `text` with what a terminal obeys or breaks a line at written as in Python."""
    return "".join(letter if letter.isprintable() else repr(letter)[1:-1] for letter in text)


def file_name(text: str) -> str:
    """Return `text` as part of a file's name: nothing in it leads to another folder."""
    return plain(text).replace("/", "-").replace("\\", "-")
