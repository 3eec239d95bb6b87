"""Inner products of the hat functions of one level.

S. Takahashi: Designing subdivision surfaces via multiresolution-based local filtering (2000), 4:
they are taken as if all faces of the cage had the same size, so that they follow from connectivity
alone, and obey ``I(k) = P(k)^T I(k+1) P(k)`` (eq. 8).
"""

from __future__ import annotations

from scipy.sparse import csr_array

from henkei._kernels import hat_products as products_of_equal_faces
from henkei.design.refinement import Connectivity, prolongation, refined


def hat_products(connectivity: Connectivity, level: int, quads: bool | None = None) -> csr_array:
    """Gram matrix I(k) of the hat functions, symmetric positive definite, ``(m, m)``.

    A triangle of the cage has area 1 if it is cut into triangles, a quad has area 1, and an n-gon
    n / 4: each of its quads is as large as those of a quad. Hats are linear on triangles, bilinear
    on quads, and on an n-gon what they are on its n quads.

    Parameters
    ----------
    level : number k of refinements of the cage that led here; a face has 4**-k of the cage's area.
    quads : faces are cut into quads; by default unless all are triangles.
    """
    if quads is None:
        quads = bool((connectivity.sizes != 3).any())
    if quads and (connectivity.sizes != 4).any():
        synthesis = prolongation(connectivity, quads)
        fine = hat_products(refined(connectivity, quads), level + 1)
        products = synthesis.T @ fine @ synthesis  # eq. 8
        return csr_array((products + products.T) / 2)
    count = connectivity.vertex_count
    start, columns, values = products_of_equal_faces(
        count, connectivity.indices, 4 if quads else 3, 4.0**-level
    )
    return csr_array((values, columns, start), shape=(count, count))
