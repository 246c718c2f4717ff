"""The paper's own figures: what follows from what, and what does not."""

import numpy as np

from harness import published


def test_nine_of_twelve_printed_errors_follow_from_the_printed_rows() -> None:
    """Error (%) is 100 (theory - FEA) / FEA, but for case 1's f2 and case 2's f5 and f6."""
    wrong = []
    for case in ("case1", "case2"):
        fea, theory, error = (
            np.array(published.table1()[case, name]) for name in ("FEA", "Theoretical", "Error (%)")
        )
        off = np.abs(100 * (theory - fea) / fea - error) > 0.00501
        wrong += [(case, f"f{i + 1}") for i in np.flatnonzero(off)]
        if case == "case2":
            of_theory = (100 * (theory - fea) / theory)[4:]
            np.testing.assert_allclose(of_theory, error[4:], atol=0.005)
    assert wrong == [("case1", "f2"), ("case2", "f5"), ("case2", "f6")]
    (erratum,) = (e for e in published.errata() if e.id == "printed-errors")
    assert erratum.statement == "0.13, 3.31 and 3.90 %"


def test_figures_quoted_for_three_elements_are_those_of_table_one() -> None:
    for (case, elements, mode), quoted in published.figure3().items():
        if elements == 3:
            assert quoted == published.table1()[case, "Error (%)"][mode - 1]
