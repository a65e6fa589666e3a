"""``rig2sea share``: a page of the report as one file to mail, HTML or PDF."""

import re
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urlsplit

from pipeline.errors import CannotComputeError, InputError, Place, reason
from pipeline.plan import UsageError, report_file
from pipeline.provenance import unwritable, write_atomically

_SCRIPT = re.compile(r'<script([^>]*)\ssrc="([^"]+)"([^>]*)></script>')
_LINK = re.compile(r'<a\b([^>]*?)\shref="([^"]*)"([^>]*)>(.*?)</a>', re.DOTALL)
_POLICY = re.compile(r'(<meta http-equiv="Content-Security-Policy" content=")[^"]*(">)')
_IMAGE = re.compile(r'(<img\b[^>]*\ssrc=")([^":]+)(")')
_KINDS = {".png": "image/png", ".jpg": "image/jpeg", ".svg": "image/svg+xml"}
#: Everything is in the file itself.
_ALONE = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"
_OUTSIDE = frozenset({"https", "http", "mailto"})
_HTML, _PDF = ".html", ".pdf"
INSTALL = "python -m pip install 'rig2sea[pdf]'"


def find_page(text: str, out: Path) -> Path:
    """Find a page: a file, or in ``reports/`` that of VEHICLE, DAY, RUN, or VEHICLE/DAY."""
    path = Path(text)
    if path.is_file():
        if path.suffix.lower() != _HTML:
            raise UsageError(f"{path}: a page of the report is expected, *.html.")
        return path
    if (path / "index.html").is_file():
        return path / "index.html"
    reports = out / "reports"
    vehicle, _, name = text.rpartition("/")
    own = out / report_file(name) if not vehicle else None
    found = [own] if own is not None and own.is_file() else []
    if not found and re.fullmatch(r"[\w .-]+", name):
        folder = vehicle or "*"
        for where in ("trials", "days", "runs", "diagnoses"):
            found += sorted(reports.glob(f"{folder}/{where}/{name}.html"))
            found += sorted(reports.glob(f"{folder}/{where}/{name}/index.html"))
    if len(found) > 1 and len({one.relative_to(reports).parts[0] for one in found}) > 1:
        there = ", ".join(str(one.relative_to(reports).parts[0]) for one in found)
        raise UsageError(f'"{text}" is of {there}; write VEHICLE/{name}, or give the page.')
    if not found:
        raise UsageError(
            f'there is no page "{text}": neither a file nor a vehicle, day or run under {reports}. '
            "`rig2sea run` makes them."
        )
    return found[0]


def share(page: Path, to: Path) -> int:
    """Write a page as one file; returns its size [bytes]."""
    kind = to.suffix.lower()
    if kind not in {_HTML, _PDF}:
        raise UsageError(f"--to {to}: a name that ends in .html or .pdf is expected.")
    if to.exists() and to.resolve() == page.resolve():
        raise UsageError(f"--to {to}: this is the page itself. Name another file.")
    try:
        text = page.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError.at(Place(str(page)), f"cannot be read: {reason(error)}.") from None
    if kind == _HTML:
        write_atomically(to, alone(text, page.parent))
    else:
        _write_pdf(alone(text, page.parent, scripts=False), to)
    return to.stat().st_size


def alone(text: str, folder: Path, *, scripts: bool = True) -> str:
    """Take what a page in a folder refers to into it; what would lead elsewhere becomes plain text.

    Without `scripts` for paper.
    """

    def script(match: re.Match[str]) -> str:
        body = _part(folder, match[2]).decode("utf-8").replace("</script", r"<\/script")
        return f"<script>{body}</script>"

    def image(match: re.Match[str]) -> str:
        import base64

        kind = _KINDS.get(Path(match[2]).suffix.lower(), "application/octet-stream")
        data = base64.b64encode(_part(folder, match[2])).decode("ascii")
        return f"{match[1]}data:{kind};base64,{data}{match[3]}"

    def link(match: re.Match[str]) -> str:
        inside = match[2].startswith("#") or urlsplit(match[2]).scheme in _OUTSIDE
        return match[0] if inside else f"<span>{match[4]}</span>"

    text = _IMAGE.sub(image, _LINK.sub(link, text))
    # deferred scripts ran at the end; inline ones run where they stand
    own = [script(match) for match in _SCRIPT.finditer(text)] if scripts else []
    before, end, after = _SCRIPT.sub("", text).rpartition("</body>")
    text = f"{before}{''.join(own)}{end}{after}"
    return _POLICY.sub(rf"\g<1>{_ALONE}\g<2>", text, count=1)


def _part(folder: Path, address: str) -> bytes:
    path = folder / unquote(urlsplit(address).path)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError.at(
            Place(str(path)),
            f"a part of the page cannot be read: {error.strerror}.",
            remedy="Make the report anew with `rig2sea run`.",
        ) from None


def _write_pdf(text: str, to: Path) -> None:
    if find_spec("weasyprint") is None:
        raise CannotComputeError(
            f"PDF needs a library that is not installed. Install it: {INSTALL}\n"
            "Or share the page as .html, which needs none."
        )
    import logging

    logging.getLogger("weasyprint").setLevel(logging.ERROR)
    try:
        from weasyprint import HTML
    except OSError as error:
        raise CannotComputeError(
            f"the library for PDF does not find its own parts (Pango): {error}\n"
            "Install Pango, or share the page as .html, which needs none."
        ) from None
    data = HTML(string=text, base_url=None).write_pdf()
    try:
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_bytes(data or b"")
    except OSError as error:
        raise unwritable(to, error) from error
