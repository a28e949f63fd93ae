"""The light-transport operator G K, for linear algebra: as scipy.sparse matrices and as LinearOperator."""
from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Any, Callable, Dict, Optional, Tuple

import numpy as np

from ._native import ffi, lib
from .arrays import ArrayLike, copy_of, floats, pointer, probes, real
from .context import Context, Handle, Object, count
from .scene import Scene

if TYPE_CHECKING:
    import scipy.sparse as sparse
    from scipy.sparse.linalg import LinearOperator

_FACTORS = {"interpolation": lib.RSV_FACTOR_INTERPOLATION, "propagation": lib.RSV_FACTOR_PROPAGATION,
            "subsurface": lib.RSV_FACTOR_SUBSURFACE, "clusters": lib.RSV_FACTOR_CLUSTERS}


class Operator(Object):
    """The fraction of the irradiance at each of N elements that arrives at each other one after one reflection.

    Fields are (N, 3) W/m2, one value for each element and colour channel. A light satisfies E = E0 + G K E.
    With A = diag(albedo),

        G K = C G A C S M C

    C interpolates hanging elements. S and M diffuse light below translucent surfaces; without any, they are the
    identity. Channels do not mix.
    """

    _made_by = "Light.operator"

    def __init__(self, context: Optional[Context] = None, handle: Optional[Handle] = None,
                 scene: Optional[Scene] = None):
        super().__init__(context, handle)
        assert scene is not None
        self._scene = scene
        self._known: Dict[Tuple[str, int], Any] = {}

    def __repr__(self) -> str:
        return f"<resolvent.Operator: {self.element_count} elements>"

    # ---- elements ----------------------------------------------------------------------------------

    @property
    def element_count(self) -> int:
        """Number of elements, N."""
        return lib.rsv_operator_element_count(self._pointer)

    @functools.cached_property
    def _elements(self) -> np.ndarray:
        layout = ffi.typeof("rsv_element")
        names = [name for name, _ in layout.fields]
        formats = {"rsv_vec3": ("f4", 3), "rsv_rgb": ("f4", 3), "float": "f4", "uint32_t": "u4", "bool": "?"}
        formats = {ffi.typeof(name): kind for name, kind in formats.items()}
        dtype = np.dtype({"names": names, "offsets": [f.offset for _, f in layout.fields],
                          "formats": [formats[f.type] for _, f in layout.fields],
                          "itemsize": ffi.sizeof("rsv_element")})
        array = np.empty(self.element_count, dtype)
        self._context.call(lib.rsv_operator_elements, self._pointer, pointer("rsv_element", array))
        array.flags.writeable = False
        return array

    @property
    def positions(self) -> np.ndarray:
        """(N, 3) metres: positions of the elements' nodes."""
        return self._scene._placed(np.ascontiguousarray(self._elements["position"]))

    @property
    def normals(self) -> np.ndarray:
        """(N, 3) unit normals."""
        return np.ascontiguousarray(self._elements["normal"])

    @property
    def areas(self) -> np.ndarray:
        """(N,) m2: integral of each element's hat function; 0 for hanging elements."""
        return np.ascontiguousarray(self._elements["area"])

    @property
    def albedo(self) -> np.ndarray:
        """(N, 3): exitance / irradiance."""
        return np.ascontiguousarray(self._elements["albedo"])

    @property
    def triangles(self) -> np.ndarray:
        """(N,) a triangle of the scene at each element."""
        return np.ascontiguousarray(self._elements["triangle"])

    @property
    def materials(self) -> np.ndarray:
        """(N,) indices into the materials of the scene."""
        return self._scene.triangle_materials[self.triangles]

    @property
    def back_sides(self) -> np.ndarray:
        """(N,) bool: whether an element is on the back of its triangle."""
        return np.ascontiguousarray(self._elements["back_side"])

    def interpolation(self, points: ArrayLike, normals: ArrayLike) -> sparse.csr_matrix:
        """The (M, N) float32 matrix W such that ``W @ field`` is the field at points, as in mode "lookup".

        points, normals : (..., 3), M points in C order. Rows are 0 on surfaces that do not reflect diffusely.
        """
        from scipy import sparse

        given, _ = probes(points, normals, self._scene.origin)
        around = np.empty((len(given), 6), np.uint32)  # rsv_element_weights
        self._context.call(lib.rsv_operator_locate_probes, self._pointer, pointer("rsv_probe", given), len(given),
                           pointer("rsv_element_weights", around))
        element, weight = around[:, :3], around[:, 3:].view(np.float32)
        row, corner = np.nonzero(weight)
        places = row, element[row, corner].astype(np.int64)
        return sparse.csr_matrix((weight[row, corner], places), (len(given), self.element_count))

    # ---- application -------------------------------------------------------------------------------

    def _applied(self, function: Callable[..., int], field: ArrayLike) -> np.ndarray:
        given = floats("field", field, (self.element_count, 3))
        image = np.empty_like(given)
        self._context.call(function, self._pointer, pointer("rsv_rgb", given), pointer("rsv_rgb", image))
        return image

    def apply(self, field: ArrayLike) -> np.ndarray:
        """G K field: (N, 3) -> (N, 3) float32. Values of hanging elements are ignored."""
        return self._applied(lib.rsv_operator_apply, field)

    def apply_transpose(self, field: ArrayLike) -> np.ndarray:
        """(G K)^T field: (N, 3) -> (N, 3) float32. Sorts the entries by column on each call; `matrix` avoids this."""
        return self._applied(lib.rsv_operator_apply_transpose, field)

    def norm(self) -> float:
        """The largest row sum over elements and channels."""
        out = ffi.new("double *")
        self._context.call(lib.rsv_operator_norm, self._pointer, out)
        return out[0]

    # ---- matrices ----------------------------------------------------------------------------------

    def factor(self, name: str, channel: int = 0) -> sparse.csr_matrix:
        """A factor of G K: "interpolation" (C), "propagation" (G), "subsurface" (S) or "clusters" (M); float64."""
        if name not in _FACTORS:
            raise ValueError(f"name: there is no factor '{name}'; there are {', '.join(_FACTORS)}")
        key = (name, count("channel", channel, 2))
        if key not in self._known:
            self._known[key] = self._read_factor(_FACTORS[name], key[1])
        return self._known[key]

    def _read_factor(self, factor: int, channel: int) -> sparse.csr_matrix:
        from scipy import sparse

        handle = self._context.create(lib.rsv_operator_matrix, "rsv_sparse_matrix", lib.rsv_sparse_matrix_destroy, None,
                                      self._pointer, factor, channel)
        try:
            m = handle.pointer
            rows = copy_of(m.row_start, (m.row_count + 1,), np.uint64).astype(np.int64)
            columns = copy_of(m.column, (int(rows[-1]),), np.uint32).astype(np.int64)
            weights = copy_of(m.weight, (int(rows[-1]),), np.float32).astype(np.float64)
            matrix = sparse.csr_matrix((weights, columns, rows), (m.row_count, m.column_count))
        finally:
            handle.release()
        matrix.sum_duplicates()
        return matrix

    def _chain(self, channel: int) -> Tuple[Any, ...]:
        """Factors of G K from left to right, without those that are the identity."""
        from scipy import sparse

        c, g = self.factor("interpolation", channel), self.factor("propagation", channel)
        every = np.arange(self.element_count)
        a = sparse.csr_matrix((self.albedo[:, channel].astype(np.float64), (every, every)), g.shape)
        s, m = self.factor("subsurface", channel), self.factor("clusters", channel)
        if m.shape[0] == m.shape[1]:  # nothing is translucent
            return c, g, a, c
        return c, g, a, c, s, m, c

    def matrix(self, channel: int = 0) -> sparse.csr_matrix:
        """G K of one channel (0 red, 1 green, 2 blue), (N, N) float64. Large translucent bodies make it dense."""
        key = ("", count("channel", channel, 2))
        if key not in self._known:
            product = functools.reduce(lambda left, right: left @ right, self._chain(channel))
            self._known[key] = product.tocsr()
        return self._known[key]

    def linear_operator(self, channel: Optional[int] = None) -> LinearOperator:
        """G K as a scipy LinearOperator, with its adjoint (`rmatvec`).

        channel : 0, 1 or 2, (N, N); None = all three, (3 N, 3 N), acting on ``field.ravel()`` of (N, 3)
        """
        from scipy.sparse.linalg import LinearOperator

        chains = [self._chain(c) for c in ((0, 1, 2) if channel is None else (count("channel", channel, 2),))]
        n, width = self.element_count, len(chains)

        def by_channel(multiply: Callable[..., np.ndarray], x: np.ndarray) -> np.ndarray:
            columns = np.asarray(x).reshape(n, width)
            return np.stack([multiply(chain, columns[:, k]) for k, chain in enumerate(chains)], axis=1).ravel()

        return LinearOperator((n * width, n * width), matvec=functools.partial(by_channel, _multiply),
                              rmatvec=functools.partial(by_channel, _multiply_transposed), dtype=np.float64)

    # ---- solving -----------------------------------------------------------------------------------

    def solve(self, source: ArrayLike, tolerance: float = 1e-8) -> np.ndarray:
        """Solves E = source + G K E: (N, 3) -> (N, 3) float64. `tolerance` is the residual relative to the source."""
        return self._solved(source, tolerance, _multiply, "source")

    def solve_adjoint(self, importance: ArrayLike, tolerance: float = 1e-8) -> np.ndarray:
        """Solves z = importance + (G K)^T z: the effect of light that starts at each element, after all reflections.

        ``(importance * solve(source)).sum()`` equals ``(solve_adjoint(importance) * source).sum()``.
        """
        return self._solved(importance, tolerance, _multiply_transposed, "importance")

    def _solved(self, right: ArrayLike, tolerance: float, multiply: Callable[..., np.ndarray], name: str) -> np.ndarray:
        given = real(name, right)
        floats(name, given, (self.element_count, 3))
        columns = [_krylov(functools.partial(multiply, self._chain(c)), given[:, c].astype(np.float64), tolerance)
                   for c in range(3)]
        return np.stack(columns, axis=1)

    def albedo_gradient(self, irradiance: ArrayLike, adjoint: ArrayLike) -> np.ndarray:
        """Derivatives of <importance, E> with respect to the albedo of each element, (N, 3).

        irradiance : E, (N, 3); adjoint : `solve_adjoint(importance)`, (N, 3)
        """
        e, z = real("irradiance", irradiance), real("adjoint", adjoint)
        for name, array in (("irradiance", e), ("adjoint", z)):
            floats(name, array, (self.element_count, 3))
        parts = []
        for c in range(3):
            chain = self._chain(c)
            parts.append(_multiply_transposed(chain[:2], z[:, c]) * _multiply(chain[3:], e[:, c]))
        return np.stack(parts, axis=1)


def _multiply(chain: Tuple[Any, ...], x: np.ndarray) -> np.ndarray:
    for factor in reversed(chain):
        x = factor @ x
    return x


def _multiply_transposed(chain: Tuple[Any, ...], x: np.ndarray) -> np.ndarray:
    for factor in chain:
        x = factor.T @ x
    return x


def _krylov(multiply: Callable[[np.ndarray], np.ndarray], right: np.ndarray, tolerance: float) -> np.ndarray:
    """Solves x = right + A x by GMRES, restarted until the true residual is small enough."""
    from scipy.sparse.linalg import LinearOperator, gmres

    size = np.linalg.norm(right)
    x = right.copy()
    residual = right + multiply(x) - x
    system = LinearOperator((len(right), len(right)), matvec=lambda v: v - multiply(v.ravel()), dtype=np.float64)
    for _ in range(200):
        if np.linalg.norm(residual) <= tolerance * size:
            return x
        step, _ = gmres(system, residual, restart=30, maxiter=1, atol=0.0)
        x = x + step
        residual = right + multiply(x) - x
    raise ArithmeticError(f"the residual stays at {np.linalg.norm(residual) / size:.2g} of the right-hand side")
