"""A session's tables as they come: line ends, compressed, Parquet, damaged, made to be too large."""

from __future__ import annotations

import gzip
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from runlog_samples import ONE_JOINT, ROWS, session_folder

from snakebot.errors import BadInputError
from snakebot.runlog import LogWarning, number_table, read_session


def test_blank_lines_at_the_end_and_crlf_are_no_rows(tmp_path: Path) -> None:
    run = read_session(session_folder(tmp_path / "s", ROWS.replace("\n", "\r\n") + "\r\n\r\n")).runs[0]
    assert len(run) == 2


def test_a_byte_order_mark_is_put_up_with(tmp_path: Path) -> None:
    assert len(read_session(session_folder(tmp_path / "s", b"\xef\xbb\xbf" + ROWS.encode())).runs[0]) == 2


def test_a_gzip_bomb_is_not_unpacked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(number_table, "MAX_TABLE_BYTES", 1 << 20)
    row = b"0.5,0.0,0.0\n"
    bomb = gzip.compress(b"t_s,cmd_1_rad,enc_1_rad\n" + row * (20 << 20 >> 3))
    folder = session_folder(tmp_path / "s", bomb, ONE_JOINT.replace("run.csv", "run.csv.gz"), "run.csv.gz")
    with pytest.raises(BadInputError, match="unpacks to more than 1 MiB"):
        read_session(folder)


def test_a_torn_gzip_is_one_line(tmp_path: Path) -> None:
    packed = gzip.compress(ROWS.encode() * 1000)
    for data in (packed[: len(packed) // 2], b"no gzip at all", packed[:-3]):
        folder = session_folder(
            tmp_path / "s", data, ONE_JOINT.replace("run.csv", "run.csv.gz"), "run.csv.gz"
        )
        with pytest.raises(BadInputError, match=r"run\.csv\.gz"):
            read_session(folder)


def test_too_many_cells_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(number_table, "MAX_CELLS", 1000)
    rows = "".join(f"{i},0,0\n" for i in range(5000))
    folder = session_folder(tmp_path / "s", "t_s,cmd_1_rad,enc_1_rad\n" + rows)
    with pytest.raises(BadInputError, match="more than 1000 cells"):
        read_session(folder)


def test_a_parquet_of_text_is_an_error_that_names_the_column(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    folder = session_folder(tmp_path / "s", text=ONE_JOINT.replace("csv", "parquet"))
    good = {"t_s": [0.0, 1.0], "cmd_1_rad": [0.0, None], "enc_1_rad": [0, 1]}
    pq.write_table(pa.table(good), folder / "run.parquet")
    np.testing.assert_array_equal(read_session(folder).runs[0].command_rad, [[0], [np.nan]])
    pq.write_table(pa.table({**good, "enc_1_rad": ["a", "b"]}), folder / "run.parquet")
    with pytest.raises(BadInputError, match="column enc_1_rad: not numbers but string"):
        read_session(folder)
    pq.write_table(pa.table({**good, "t_s": [1.0, 1.0]}), folder / "run.parquet")
    with pytest.raises(BadInputError, match="row 2, column t_s: time does not rise"):
        read_session(folder)
    (folder / "run.parquet").write_bytes(b"PAR1 no table PAR1")
    with pytest.raises(BadInputError, match=r"run\.parquet"):
        read_session(folder)


def test_a_parquet_bomb_is_not_unpacked(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    folder = session_folder(tmp_path / "s", text=ONE_JOINT.replace("csv", "parquet"))
    zeros = pa.table({name: np.zeros(1_000_000) for name in ("t_s", "cmd_1_rad", "enc_1_rad")})
    with pq.ParquetWriter(folder / "run.parquet", zeros.schema) as writer:
        for _ in range(20):
            writer.write_table(zeros)
    assert (folder / "run.parquet").stat().st_size < 1_000_000
    with pytest.raises(BadInputError, match="20000000 rows of 3 columns are too many"):
        read_session(folder)


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=300))
def test_any_bytes_as_a_table_are_rows_or_one_line(
    tmp_path_factory: pytest.TempPathFactory, data: bytes
) -> None:
    folder = tmp_path_factory.mktemp("fuzz")
    for table in (data, b"t_s,cmd_1_rad,enc_1_rad\n" + data):
        _one_line_or_rows(session_folder(folder, table))


def _one_line_or_rows(folder: Path) -> None:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LogWarning)
            read_session(folder)
    except BadInputError as error:
        assert "\n" not in str(error)  # noqa: PT017
