import hashlib
import hmac
import shutil
import subprocess
from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from emovid.kit.seeded_random import commitment, draw, fresh_seed, is_code, salt, share, shuffled, video_codes

SEEDS = st.integers(0, 2**256 - 1)


def test_draw_is_a_keyed_hash_of_its_purpose() -> None:
    expected = hmac.new(b"7", b"emovid kit/run/abc/0", hashlib.sha256).hexdigest()
    assert draw(7, "run", "abc", 0) == int(expected, 16)


@given(SEEDS, st.integers(1, 200))
def test_codes_are_distinct_unambiguous_and_not_words(seed, count) -> None:
    codes = video_codes(seed, count)
    assert len(set(codes)) == count
    assert all(is_code(code) for code in codes)
    assert not set("".join(codes)) & set("aeiouy01los52z")
    assert all(code[0].isalpha() and len(code) == 6 for code in codes)


@given(SEEDS, SEEDS)
def test_two_kits_share_no_code(seed, other) -> None:
    if seed != other:
        assert not set(video_codes(seed, 12)) & set(video_codes(other, 12))


@given(SEEDS, st.lists(st.integers(), max_size=30))
def test_shuffle_is_a_reproducible_permutation(seed, items) -> None:
    mixed = shuffled(items, seed, "x")
    assert Counter(mixed) == Counter(items)
    assert mixed == shuffled(items, seed, "x")


def test_all_orders_of_three_are_equally_likely() -> None:
    counts = Counter(tuple(shuffled("abc", seed)) for seed in range(6000))
    assert len(counts) == 6
    assert sum((count - 1000) ** 2 / 1000 for count in counts.values()) < 20.5  # chi-squared, 5 d.o.f., p = 0.001


def test_shares_are_uniform_on_the_unit_interval() -> None:
    shares = [share(seed, "turn") for seed in range(4000)]
    assert 0 <= min(shares) < 0.01
    assert 0.99 < max(shares) < 1
    assert abs(sum(shares) / 4000 - 0.5) < 0.02


def test_new_seeds_are_long_and_distinct() -> None:
    seeds = {fresh_seed() for _ in range(50)}
    assert len(seeds) == 50
    assert min(seeds) > 2**200


def test_commitment_can_be_verified_with_coreutils(tmp_path) -> None:
    (tmp_path / "salt.txt").write_text(salt(5) + "\n")
    (tmp_path / "key.csv").write_text("video_code,true_emotion\nbcdfgh,fear\n")
    data = [(tmp_path / name).read_bytes() for name in ("salt.txt", "key.csv")]
    assert commitment(*data) == hashlib.sha256(b"".join(data)).hexdigest()
    sha256sum = shutil.which("sha256sum")
    if sha256sum:  # not available everywhere: macOS has shasum
        both = (tmp_path / "salt.txt").read_bytes() + (tmp_path / "key.csv").read_bytes()
        said = subprocess.run([sha256sum], input=both, capture_output=True, check=True)
        assert said.stdout.decode().split()[0] == commitment(*data)
