"""Files appear whole or not at all; nothing is left behind, and nothing stale stays."""

import json
import os
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest

import voronec as vo
from voronec.cli import main
from voronec.cli.files import create, deliver, wanted_folder
from voronec.declaration.whole_files import (
    Store,
    draft,
    keep_file,
    keep_with_digest,
    read_with_digest,
    replace_file,
    user_cache,
    workshop,
)
from voronec.errors import DefinitionError

pytestmark = pytest.mark.slow

KILLED = """
import os, signal, sys
from pathlib import Path
from voronec.declaration.whole_files import workshop
with workshop(Path(sys.argv[1])) as made:
    (made / "big").write_bytes(bytes(1000))
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_what_a_killed_process_left_goes_with_the_next_writing(tmp_path):
    subprocess.run([sys.executable, "-c", KILLED, str(tmp_path)])
    assert any(tmp_path.iterdir())
    with workshop(tmp_path), workshop(tmp_path) as other:  # one that lives stays
        assert other.is_dir() and len(list(tmp_path.iterdir())) == 2
    assert not any(tmp_path.iterdir())


def test_a_file_stays_as_it_was_where_the_disk_is_full(tmp_path):
    code = (
        "import resource, signal, sys; from pathlib import Path\n"
        "sys.dont_write_bytecode = True\n"  # which would be cut short too
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
        "from voronec.cli.files import create\n"
        "from voronec.declaration.whole_files import replace_file\n"
        "from voronec.errors import DefinitionError\n"
        "for write in (replace_file, create):\n"
        "    try: write(Path(sys.argv[1]) / write.__name__, 'x' * 1000)\n"
        "    except DefinitionError as error: print(error)\n"
    )
    old = tmp_path / "replace_file"
    old.write_text("old")
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)], capture_output=True, text=True
    )
    assert done.stdout.count("cannot be written") == 2 and not done.stderr
    assert old.read_text() == "old" and [*tmp_path.iterdir()] == [old]


@pytest.mark.parametrize(
    "text", [b"", b"\xff", b"{}", b"3", b"null", b"[1, 2]", b'["a", "{}"]', b'["a", "{}", 1]']
)
def test_a_kept_result_that_is_damaged_is_named_once_and_replaced(tmp_path, text):
    store, key = Store(tmp_path), "k" * 24
    store.save(key, "part", {"a": 1})
    assert store.load(key, "part") == {"a": 1}
    (file,) = (f for f in tmp_path.rglob("*") if f.is_file())
    file.write_bytes(text)
    with pytest.warns(UserWarning, match=f"'{file}' is damaged; it is made anew"):
        assert store.load(key, "part") is None
    assert store.load(key, "part") is None
    store.save(key, "part", {"a": 2})
    assert store.load(key, "part") == {"a": 2}


def test_drafts_that_fail_leave_nothing(tmp_path):
    target = tmp_path / "x.txt"
    with pytest.raises(KeyError), draft(target) as new:
        {}[new.write_text("half")]
    assert not any(tmp_path.iterdir())
    for place in (tmp_path / ("a" * 300), tmp_path / "none" / "x", Path("/dev/null/x")):
        with pytest.raises(DefinitionError, match="cannot be written"):
            replace_file(place, "x")
    replace_file(target, "θ")
    assert target.read_bytes() == "θ".encode()
    with pytest.raises(DefinitionError, match="exists"):
        create(target, "new")
    assert target.read_text(encoding="utf-8") == "θ" and [*tmp_path.iterdir()] == [target]


def test_an_old_picture_goes_where_the_new_run_has_none(tmp_path):
    for names in (("a.csv", "path.svg"), ("a.csv",)):
        write = lambda made, names=names: [(made / n).write_text("x") for n in names]  # noqa: E731
        deliver(tmp_path / "out", write, ("a.csv", "path.svg", "plot.svg"))
        (tmp_path / "out" / "mine.svg").write_text("mine")
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"a.csv", "mine.svg"}


@pytest.mark.parametrize("name", ["a" * 300, "x\0y", "/dev/null/x", " "])
def test_a_folder_that_cannot_be_is_refused_before_the_work(name):
    with pytest.raises(DefinitionError):
        wanted_folder(name)


@pytest.mark.parametrize("write", [replace_file, create])
def test_a_name_that_no_file_can_have_is_one_line(tmp_path, write):
    with pytest.raises(DefinitionError, match=r"cannot be written: .*; choose another place"):
        write(tmp_path / "\ud800", "x")
    with pytest.raises(DefinitionError):
        wanted_folder("\ud800")
    assert not any(tmp_path.iterdir())


def _shell(line, **env):
    return subprocess.run(
        ["bash", "-c", line.replace("voronec", f"{sys.executable} -m voronec")],
        env={**os.environ, **env}, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("line", "status", "word"),
    [
        ("voronec cite sleigh >&-", 2, "write error: Bad file descriptor"),
        ("voronec list --json <&- >&-", 2, "write error: Bad file descriptor"),
        ("voronec --help >&-", 2, "write error: Bad file descriptor"),
        ("voronec cite sleigh >&- 2>&-", 2, ""),
        ("voronec cite sleigh 2>&-", 0, ""),
        ("voronec cite nobody 2>&-", 2, ""),
        ("voronec cite sleigh >/dev/full", 2, "No space left"),
        ("voronec --help >/dev/full", 2, "No space left"),
        ("voronec bench sleigh $'\\e[31m'", 2, r"\x1b[31m' is one argument too many; see"),
        ("voronec list | true", 0, ""),
        ("mkdir gone; cd gone; rmdir ../gone; voronec new a-b", 2, "cannot be written"),
    ],
)
def test_output_that_is_closed_or_full_is_no_traceback(line, status, word, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = _shell(line)
    assert done.returncode == status and word in done.stderr
    assert "Traceback" not in done.stderr and "ignored" not in done.stderr
    assert len(done.stderr.splitlines()) <= 1


def test_letters_that_a_terminal_lacks_are_written_by_their_number(tmp_path):
    file = tmp_path / "x.py"
    file.write_text(
        "import sympy as sp, voronec as vo\nθ = sp.Symbol('θ')\n"
        "SYSTEM = vo.System(name='s', fibration=vo.Fibration((θ,)), "
        "lagrangian=vo.velocity(θ)**2)\n",
        encoding="utf-8",
    )
    done = _shell(f"voronec derive {file}", PYTHONIOENCODING="ascii")
    assert done.returncode == 0 and r"\u03b8" in done.stdout and not done.stderr


def test_what_nobody_foresaw_is_one_line(monkeypatch, capsys):
    def broken(_):
        raise KeyError("two\nlines")

    monkeypatch.setattr("voronec.cli.citation.execute", broken)
    assert main(["cite", "sleigh"]) == 1
    told = capsys.readouterr().err
    assert told.startswith("voronec: a fault of voronec: KeyError in") and told.count("\n") == 1
    monkeypatch.setenv("VORONEC_TRACEBACK", "1")
    with pytest.raises(KeyError):
        main(["cite", "sleigh"])


def test_a_film_that_is_stopped_leaves_nothing(tmp_path):
    """Killed while it draws: the next run clears away what is left."""
    code = [sys.executable, "-c", KILLED.replace("os.kill(os.getpid(), signal.SIGKILL)",
            "print(1, flush=True); import time; time.sleep(60)"), str(tmp_path)]  # fmt: skip
    with subprocess.Popen(code, stdout=subprocess.PIPE) as work:
        assert work.stdout is not None
        work.stdout.readline()
        with workshop(tmp_path):
            assert len(list(tmp_path.iterdir())) == 2  # it lives, so it stays
        os.kill(work.pid, signal.SIGKILL)
        work.wait()
    with workshop(tmp_path):
        assert len(list(tmp_path.iterdir())) == 1


def test_a_window_that_is_not_there_is_not_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = _shell("voronec run sleigh --times 0:1:3 --out out", MPLBACKEND="nonsense")
    assert done.returncode == 0 and not done.stderr
    assert {p.name for p in Path("out").iterdir()} == {"plot.svg", "path.svg", "trajectory.csv"}
    before = os.environ.get("MPLBACKEND")
    main(["cite", "sleigh"])
    assert os.environ.get("MPLBACKEND") == before


@pytest.mark.skipif(os.name == "nt", reason="no such files there")
def test_what_is_no_file_is_not_replaced(tmp_path):
    pipe = tmp_path / "pipe.txt"
    os.mkfifo(pipe)
    with pytest.raises(DefinitionError, match="no file that could be replaced"):
        replace_file(pipe, "text")
    assert pipe.is_fifo() and [*tmp_path.iterdir()] == [pipe]


UNIX = pytest.mark.skipif(sys.platform != "linux", reason="caches lie elsewhere, or have no modes")


def owned(place):
    if os.geteuid():
        pytest.skip("only root gives files away")
    os.chown(place, 65534, 65534)


def writable(place):
    place.chmod(0o777 if place.is_dir() else 0o666)


def linked(place):
    place.rename(place.with_name("elsewhere"))
    place.symlink_to(place.with_name("elsewhere"))


@UNIX
@pytest.mark.parametrize("give", [owned, writable, linked])
@pytest.mark.parametrize(
    "inside",
    ["", "voronec", "voronec/part", f"voronec/part/{'k' * 24}", f"voronec/part/{'k' * 24}/x.json"],
)
def test_a_cache_that_others_can_change_is_named_once_and_not_used(
    tmp_path, monkeypatch, give, inside
):
    base = tmp_path / "base"
    monkeypatch.setenv("XDG_CACHE_HOME", str(base))
    Store.of_user("part").save("k" * 24, "x", 1)
    assert Store.of_user("part").load("k" * 24, "x") == 1
    if give is linked and not inside:
        pytest.skip("the folder of all caches may be a link")
    (kept,) = base.rglob("x.json")
    before = kept.read_bytes()
    give(base / inside)
    with pytest.warns(UserWarning, match="belongs to another user") as told:
        assert Store.of_user("part").load("k" * 24, "x") is None
    assert len(told) == 1 and f"'{base / inside}'" in str(told[0].message)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Store.of_user("part").load("k" * 24, "x") is None
        Store.of_user("part").save("k" * 24, "x", 2)
        replaced = inside.endswith(".json")  # in a folder of ours what others own gives way
        assert Store.of_user("part").load("k" * 24, "x") == (2 if replaced else None)
    assert replaced or kept.read_bytes() == before
    assert not (replaced and give is linked) or (kept.parent / "elsewhere").read_bytes() == before


@UNIX
def test_folders_of_caches_are_private(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "new"))
    (tmp_path / "new" / "voronec").mkdir(parents=True)
    (tmp_path / "new").chmod(0o755)
    (tmp_path / "new" / "voronec").chmod(0o755)
    mask = os.umask(0)
    try:
        Store.of_user("part").save("k" * 24, "x", 1)
    finally:
        os.umask(mask)
    for place in (tmp_path / "new" / "voronec").rglob("*"):
        assert place.stat().st_mode & 0o777 == (0o700 if place.is_dir() else 0o600), place
    assert (tmp_path / "new" / "voronec").stat().st_mode & 0o777 == 0o700


@UNIX
@pytest.mark.parametrize("cache", ["", "here", "./here", None])
@pytest.mark.parametrize("home", ["", "here", None])
def test_names_of_caches_that_are_empty_or_relative_are_ignored(tmp_path, monkeypatch, cache, home):
    monkeypatch.chdir(tmp_path)
    for name, value in (("XDG_CACHE_HOME", cache), ("HOME", home)):
        if value is None:
            monkeypatch.delenv(name, raising=False)
        else:
            monkeypatch.setenv(name, value)
    monkeypatch.setattr("os.path.expanduser", lambda path: str(tmp_path / "home"))
    expected = tmp_path / "home" / ".cache" if home is None else Path(os.devnull)
    assert user_cache("part") == expected / "voronec" / "part"
    assert [*tmp_path.iterdir()] == ([tmp_path / "home"] if home is None else [])


@UNIX
def test_drafts_follow_no_links(tmp_path):
    """A draft by a name that can be guessed is not written, a lock that leads away not opened."""
    victim = tmp_path / "victim"
    victim.write_text("mine")
    tmp_path.chmod(0o700)
    for guess in (f"x.{os.getpid()}", "x"):
        (tmp_path / guess).symlink_to(victim)
    keep_file(tmp_path / "x.json", b"kept")
    (tmp_path / ".voronec-guess").mkdir()
    (tmp_path / ".voronec-guess" / "lock").symlink_to(victim)
    keep_file(tmp_path / "x", b"kept")
    replace_file(tmp_path / "y", "kept")
    assert victim.read_text() == "mine" and (tmp_path / "x").read_bytes() == b"kept"
    assert not (tmp_path / "x").is_symlink() and (tmp_path / ".voronec-guess" / "lock").is_symlink()


MANY = """
import sys
from pathlib import Path
from voronec.declaration.whole_files import keep_with_digest
for n in range(60):
    keep_with_digest(Path(sys.argv[1]), sys.argv[2].encode() * (100 * n + 1))
"""


def test_what_threads_and_processes_write_at_once_is_whole(tmp_path):
    file = tmp_path / "folder" / "x"
    keep_with_digest(file, b"a")

    def write(letter):
        for n in range(60):
            keep_with_digest(file, letter * (100 * n + 1))

    threads = [threading.Thread(target=write, args=(letter,)) for letter in (b"a", b"b")]
    command = [sys.executable, "-c", MANY, str(file)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        processes = [subprocess.Popen([*command, letter]) for letter in "cd"]
        for thread in threads:
            thread.start()
        while any(t.is_alive() for t in threads) or any(p.poll() is None for p in processes):
            content = read_with_digest(file, "thing")
            assert content and len({*content}) == 1
    assert not any(p.returncode for p in processes)
    assert [*file.parent.iterdir()] == [file], "no draft is left"


# -- results in files --------------------------------------------------------------------------

BALL = vo.load("chaplygin-ball")


@pytest.fixture(scope="module")
def results():
    sleigh = vo.load("sleigh")
    turn = vo.Event("w - 1/10", name="turn")
    return (
        vo.integrate(sleigh, times=[0, 1, 2], outputs=("x", "x/(1 + y**2)"), events=(turn,)),
        vo.ensemble(sleigh, {"v": [1, 2, 3], "w": [0.1, 2, np.nan]}, times=[0, 1, 2]),
        vo.section(BALL, "omega3", crossings=5, starts=3),
        vo.integrate(sleigh, times=[0, 1], outputs=("x",), tol=1e-30),
    )


@pytest.mark.parametrize("suffix", ["npz", "parquet", "zarr"])
def test_what_is_saved_opens_as_it_was(results, suffix, tmp_path):
    xarray = pytest.importorskip("xarray")
    for result in results:
        for _ in range(2):  # one that is there is replaced
            opened = vo.open(result.save(tmp_path / f"a.{suffix}"))
        xarray.testing.assert_identical(opened.load(), result.to_xarray())
        assert [p.name for p in tmp_path.iterdir()] == [f"a.{suffix}"]
        assert opened.attrs["kind"] == type(result).__name__.removeprefix("Late")
        assert opened.attrs["versions"]["voronec"] == vo.__version__
        assert opened["v" if result.system.name == "sleigh" else "omega1"].size


def test_datasets_and_tables_have_all_numbers_meanings_and_errors(results):
    pytest.importorskip("xarray")
    run, many, section, _ = results
    assert np.array_equal(run.to_xarray()["turn: x"], run.events["turn"]["x"])
    assert np.array_equal(many.to_pandas()["w"].to_numpy().reshape(3, 3), many["w"], equal_nan=True)
    assert str(many.to_xarray()["error"].values[2]) == str(many.errors[2])
    assert section.to_pandas()["omega1"].tolist() == section["omega1"].tolist()
    meant = {p.name: p.meaning for p in BALL.parameters}
    assert meant["I1"] and section.to_xarray()["I1"].attrs["long_name"] == meant["I1"]
    for result in results[:3]:
        assert result.plot().axes


def test_what_cannot_be_opened_or_written_over_is_refused_in_one_line(results, tmp_path):
    pytest.importorskip("xarray")
    run, place = results[0], tmp_path / "a.npz"
    with pytest.raises(DefinitionError, match=r"holds a result.*voronec\.open"):
        vo.load(str(run.save(place)))
    held = dict(np.load(place))
    header = json.loads(str(held["voronec"]))
    for change, message in (
        ({"format": 99, "versions": {"voronec": "7.1"}}, r"saved by voronec 7\.1.*update"),
        ({"format": None}, "holds no result"),
        ({"axes": {"x": ["t", "u"]}}, "is damaged"),
    ):
        np.savez(place, **{**held, "voronec": np.array(json.dumps({**header, **change}))})
        with pytest.raises(DefinitionError, match=message):
            vo.open(place)
    for name, content in (("b.npz", b"PK nothing"), ("c.parquet", b"PAR1"), ("d.npz", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(DefinitionError, match="is damaged"):
            vo.open(tmp_path / name)
    np.savez(tmp_path / "pickled.npz", voronec=np.array([Path("x")], dtype=object))
    with pytest.raises(DefinitionError, match="is damaged"):
        vo.open(tmp_path / "pickled.npz")
    (tmp_path / "mine.zarr").mkdir()
    for suffix, message in (("mine.zarr", "no saved result"), ("a.txt", "must end in")):
        with pytest.raises(DefinitionError, match=message):
            run.save(tmp_path / suffix)
    for suffix, message in (("e.npz", "no file"), ("e.zarr", "no file"), ("a.txt", "must end")):
        with pytest.raises(DefinitionError, match=message):
            vo.open(tmp_path / suffix)


def test_a_trajectory_of_version_0_9_opens(tmp_path):
    pytest.importorskip("xarray")
    names = np.array(["x", "v"])
    held = {"x": np.arange(2.0), "t": np.arange(2.0), "state": np.eye(2), "names": names}
    np.savez(tmp_path / "old.npz", **held, **{"parameter a": np.array(0.3)})
    opened = vo.open(tmp_path / "old.npz")
    assert opened["v"].values.tolist() == [0, 1] and opened.attrs["parameters"] == {"a": 0.3}


def test_without_its_library_a_result_says_what_to_install(results, monkeypatch):
    monkeypatch.setitem(sys.modules, "xarray", None)
    with pytest.raises(DefinitionError, match=r"pip install 'voronec\[sweeps\]'"):
        results[1].to_xarray()
