import pytest

from sonoglide import Link, LinkError, SceneError


def test_a_simulated_board_scans_locks_and_drives():
    with Link("sim:lock") as board:
        assert board.identify()["firmware"]
        assert board.scan()["series_resonance_hz"] == pytest.approx(40_400, rel=0.02)
        board.lock()
        answer = board.drive(volts=2)
        assert answer["mode"] == "run" and "drive is on" in str(answer)
        board.wait(0.05)
        assert board.stop()["mode"] == "idle"


def test_a_capture_leaves_its_files(tmp_path):
    with Link("sim:lock") as board:
        board.drive(volts=2)
        board.capture(tmp_path / "capture of today")
        assert (tmp_path / "capture of today" / "capture.csv").exists()


def test_a_refusal_is_an_exception():
    with Link("sim:lock") as board:
        with pytest.raises(LinkError, match="did you mean|similar|unrecognized"):
            board.run("scann")
        with pytest.raises(LinkError):
            board.drive(volts=-1)
        assert board.status()["mode"] == "idle"
    with pytest.raises(LinkError, match="closed"):
        board.status()


def test_a_missing_board_is_an_exception():
    with pytest.raises(LinkError, match="/dev/no-such-port"):
        Link("/dev/no-such-port")
    with pytest.raises(LinkError, match="no \\[controller\\]"):
        Link("sim:contact")
    with pytest.raises(SceneError, match="lock"):
        Link("sim:lockk")
    with pytest.raises(LinkError, match="simulated"):
        Link("/dev/no-such-port", {"stack.bvd.q": 3})
