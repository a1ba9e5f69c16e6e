"""No committed notebook, number or picture is older than the code or data that made it, unless that is admitted."""

from stylephase.report import fresh, made


def test_what_is_stale_is_admitted_with_a_reason_and_nothing_else_is(root):
    stale = fresh.stale(root)
    admitted = made.admitted(root)
    assert all(reason.strip() for reason in admitted.values())
    assert admitted.keys() - stale.keys() == set(), f"fresh again; take it out of {made.LISTED}"
    assert {name: what for name, what in stale.items() if name not in admitted} == {}, "make figures makes them again"
