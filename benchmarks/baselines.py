"""What the flight simulator costs without parakin: a SciPy script and a C kernel.

`solve_motion_scipy` is what a user would write today from the paper: the twelve scalar equations
(7) go to `scipy.optimize.root` with their Jacobian, each sample starting from the previous one,
and the same matrix gives velocities and accelerations. It is written with some care: the Jacobian
is analytic, and scalars are Python floats, which are faster than NumPy's.

`build_c_strokes` compiles the closed form of the three strokes, as a competent engineer would write
it for a controller.

Both take poses (x, y, phi) in m and rad, and give the coordinates of tests/oracles/closed_form.py:
absolute angles, displacements A2, B3, C3 from the printed s_A, s_B, s_C, and E2P = D2E2.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from shutil import which
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root  # type: ignore[import-untyped, unused-ignore]

Floats: TypeAlias = NDArray[np.floating[Any]]

# The paper's lengths [m]
D1, D2, D3, D4, D5 = 0.4, 0.95, 0.65, 0.25, 1.35
L1, L2, L3, L4 = 0.85, 1.0, 1.3, 1.2
B, H, H_G = 1.2, 1.4, 1.1
S_A, S_B, S_C = 0.29, 0.33, 0.33

COORDINATES = ("A1", "A2", "A3", "B1.1", "B1.2", "B3", "C1.1", "C1.2", "C3", "D1", "E1", "E2P")

# A rough reading of the paper's Fig. 2: close enough to start from at the central configuration
GUESS = np.array([1.2, 0.0, 1.1, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 2.2, 1.1, 0.6])


def residual(q: Floats, y: Floats) -> Floats:
    """Equations (7): two rows for each of the chains A, D, E and three for B and C."""
    a, la, a3, f, g, lb, i, j, lc, d, e, s = q.tolist()
    x, y_, phi = y.tolist()
    rod_x, rod_y = cos(a - a3), sin(a - a3)
    arm_x, arm_y, arm_z = B / 2 * sin(phi) * rod_y, -B / 2 * sin(phi) * rod_x, B / 2 * cos(phi)
    la, lb, lc = S_A + L1 + la, S_B + L2 + lb, S_C + L2 + lc
    foot = D2 + D3 + D4
    return np.array(
        [
            la * cos(a) + H * rod_x - x,
            la * sin(a) + H * rod_y - y_,
            foot - lb * sin(f) * sin(g) - arm_x - x,
            lb * cos(f) * sin(g) - arm_y - y_,
            D5 - lb * cos(g) - arm_z,
            foot - lc * sin(i) * sin(j) + arm_x - x,
            lc * cos(i) * sin(j) + arm_y - y_,
            -D5 + lc * cos(j) + arm_z,
            D2 + D3 + L3 * cos(d) + (H - D1) * rod_x - x,
            L3 * sin(d) + (H - D1) * rod_y - y_,
            D2 + L4 * cos(e) + (H - D1 - s) * rod_x - x,
            L4 * sin(e) + (H - D1 - s) * rod_y - y_,
        ]
    )


def jacobian(q: Floats, y: Floats) -> Floats:
    """Derivative of the residual by the twelve coordinates."""
    a, la, a3, f, g, lb, i, j, lc, d, e, s = q.tolist()
    rod_x, rod_y = cos(a - a3), sin(a - a3)
    la, lb, lc = S_A + L1 + la, S_B + L2 + lb, S_C + L2 + lc
    half_sin, rest = B / 2 * sin(y[2]), H - D1 - s
    m = np.zeros((12, 12))
    m[0, :3] = -la * sin(a) - H * rod_y, cos(a), H * rod_y
    m[1, :3] = la * cos(a) + H * rod_x, sin(a), -H * rod_x
    m[2, 0], m[2, 2] = -half_sin * rod_x, half_sin * rod_x
    m[3, 0], m[3, 2] = -half_sin * rod_y, half_sin * rod_y
    m[2, 3:6] = -lb * cos(f) * sin(g), -lb * sin(f) * cos(g), -sin(f) * sin(g)
    m[3, 3:6] = -lb * sin(f) * sin(g), lb * cos(f) * cos(g), cos(f) * sin(g)
    m[4, 4:6] = lb * sin(g), -cos(g)
    m[5, 0], m[5, 2] = half_sin * rod_x, -half_sin * rod_x
    m[6, 0], m[6, 2] = half_sin * rod_y, -half_sin * rod_y
    m[5, 6:9] = -lc * cos(i) * sin(j), -lc * sin(i) * cos(j), -sin(i) * sin(j)
    m[6, 6:9] = -lc * sin(i) * sin(j), lc * cos(i) * cos(j), cos(i) * sin(j)
    m[7, 7:9] = -lc * sin(j), cos(j)
    m[8, 0], m[8, 2], m[8, 9] = -(H - D1) * rod_y, (H - D1) * rod_y, -L3 * sin(d)
    m[9, 0], m[9, 2], m[9, 9] = (H - D1) * rod_x, -(H - D1) * rod_x, L3 * cos(d)
    m[10, 0], m[10, 2], m[10, 10:] = -rest * rod_y, rest * rod_y, (-L4 * sin(e), -rod_x)
    m[11, 0], m[11, 2], m[11, 10:] = rest * rod_x, -rest * rod_x, (L4 * cos(e), -rod_y)
    return m


def by_pose(q: Floats, y: Floats) -> Floats:
    """Derivative of the residual by (x, y, phi)."""
    gamma, c, s = q[0] - q[2], B / 2 * cos(y[2]), B / 2 * sin(y[2])
    m = np.zeros((12, 3))
    m[[0, 2, 5, 8, 10], 0] = -1
    m[[1, 3, 6, 9, 11], 1] = -1
    m[2:5, 2] = -c * sin(gamma), c * cos(gamma), s
    m[5:8, 2] = c * sin(gamma), -c * cos(gamma), -s
    return m


def rate_terms(q: Floats, qd: Floats, y: Floats, yd: Floats) -> Floats:
    """Jacobian-dot times velocity: the second derivative of the residual at qdd = ydd = 0."""
    a, la, a3, f, g, lb, i, j, lc, d, e, s = q.tolist()
    ad, lad, a3d, fd, gd, lbd, id_, jd, lcd, dd, ed, sd = qd.tolist()
    phi, phid = y[2], yd[2]
    la, lb, lc = S_A + L1 + la, S_B + L2 + lb, S_C + L2 + lc
    rod_x, rod_y, turn = cos(a - a3), sin(a - a3), ad - a3d
    rest = H - D1 - s

    # of the arm (sin phi rod_y, -sin phi rod_x, cos phi) b/2
    k, m = -(phid**2 + turn**2) * sin(phi), 2 * phid * turn * cos(phi)
    arm_x, arm_y = B / 2 * (k * rod_y + m * rod_x), B / 2 * (-k * rod_x + m * rod_y)
    arm_z = -B / 2 * phid**2 * cos(phi)

    def leg(f: float, g: float, length: float, *rates: float) -> tuple[float, float, float]:
        """Of length (-sin f sin g, cos f sin g, cos g)."""
        fd, gd, v = rates
        rho = 2 * v * gd * cos(g) - length * gd**2 * sin(g) - length * sin(g) * fd**2
        tangent = 2 * fd * (v * sin(g) + length * gd * cos(g))
        return (
            -rho * sin(f) - tangent * cos(f),
            rho * cos(f) - tangent * sin(f),
            -2 * v * gd * sin(g) - length * gd**2 * cos(g),
        )

    bx, by, bz = leg(f, g, lb, fd, gd, lbd)
    cx, cy, cz = leg(i, j, lc, id_, jd, lcd)
    fixed, sliding = -(turn**2), -(turn**2) * rest
    return np.array(
        [
            -2 * lad * ad * sin(a) - la * ad**2 * cos(a) + H * fixed * rod_x,
            2 * lad * ad * cos(a) - la * ad**2 * sin(a) + H * fixed * rod_y,
            bx - arm_x,
            by - arm_y,
            -bz - arm_z,
            cx + arm_x,
            cy + arm_y,
            cz + arm_z,
            -L3 * dd**2 * cos(d) + (H - D1) * fixed * rod_x,
            -L3 * dd**2 * sin(d) + (H - D1) * fixed * rod_y,
            -L4 * ed**2 * cos(e) + sliding * rod_x + 2 * sd * turn * rod_y,
            -L4 * ed**2 * sin(e) + sliding * rod_y - 2 * sd * turn * rod_x,
        ]
    )


def scipy_user(
    y: Floats, yd: Floats, ydd: Floats, guess: Floats, analytic: bool = True
) -> tuple[Floats, Floats, Floats]:
    """Position, velocity and acceleration of the twelve coordinates at one pose (x, y, phi)."""
    solution = root(residual, guess, args=(y,), jac=jacobian if analytic else None, tol=1e-12)
    q: Floats = solution.x
    if not solution.success and np.abs(residual(q, y)).max() > 1e-10:
        raise RuntimeError(solution.message)
    m, n = jacobian(q, y), by_pose(q, y)
    qd = np.linalg.solve(m, -n @ yd)
    qdd = np.linalg.solve(m, -n @ ydd - rate_terms(q, qd, y, yd))
    return q, qd, qdd


def solve_motion_scipy(
    y: Floats, yd: Floats, ydd: Floats, analytic: bool = True
) -> tuple[Floats, Floats, Floats]:
    """The same for a motion, (N, 3) to (N, 12): each sample starts from the previous one."""
    q, qd, qdd = (np.empty((len(y), len(COORDINATES))) for _ in range(3))
    guess = GUESS
    for k in range(len(y)):
        q[k], qd[k], qdd[k] = scipy_user(y[k], yd[k], ydd[k], guess, analytic)
        guess = q[k]
    return q, qd, qdd


C_SOURCE = """
#include <math.h>

#ifdef SIMD /* gcc fuses sin and cos of one angle into sincos, which it does not vectorise */
#define COS(angle) sin((angle) + 1.5707963267948966)
#else
#define COS(angle) cos(angle)
#endif

/* Strokes of the three actuators, from the printed home lengths, over n poses. */
void strokes(long n, const double *restrict x, const double *restrict y,
             const double *restrict phi, double *restrict a, double *restrict b,
             double *restrict c)
{
    const double l3 = %(L3)r, rod = %(H)r - %(D1)r, h = %(H)r, half = 0.5 * %(B)r;
    const double xd = %(D2)r + %(D3)r, foot = xd + %(D4)r, d5 = %(D5)r;
    const double la = %(S_A)r + %(L1)r, lb = %(S_B)r + %(L2)r, lc = %(S_C)r + %(L2)r;

    for (long i = 0; i < n; i++) {
        /* D2, where the circle of the crank about D1 meets that of the rod about G */
        const double u = x[i] - xd, v = y[i], square = u * u + v * v;
        const double dot = 0.5 * (square + (l3 * l3 - rod * rod)), inverse = 1.0 / square;
        const double across = sqrt(l3 * l3 * square - dot * dot) * inverse;
        const double along = dot * inverse;

        /* the rod, and the end A3 of the leg A */
        const double rod_x = (u - along * u + across * v) * (1.0 / rod);
        const double rod_y = (v - along * v - across * u) * (1.0 / rod);
        const double ax = x[i] - h * rod_x, ay = y[i] - h * rod_y;

        /* the arms from G to B4 and, opposite, to C4 */
        const double s = half * sin(phi[i]), z = d5 - half * COS(phi[i]);
        const double wx = s * rod_y, wy = -s * rod_x, px = x[i] - foot;
        const double bx = px + wx, by = v + wy, cx = px - wx, cy = v - wy;

        a[i] = sqrt(ax * ax + ay * ay) - la;
        b[i] = sqrt(bx * bx + by * by + z * z) - lb;
        c[i] = sqrt(cx * cx + cy * cy + z * z) - lc;
    }
}
"""
COMPILE = ("gcc", "-O3", "-march=native", "-ffast-math", "-shared", "-fPIC")


def build_c_strokes(simd: bool = True) -> Callable[[Floats, Floats, Floats, Floats], None] | None:
    """The C kernel as a function (x, y, phi, out) that fills out (3, n); None without gcc.

    The arrays are float64, contiguous and writable. As first written (simd = False) gcc leaves the
    loop scalar; one changed line lets it use the vector sine of libmvec, five times faster.
    """
    if which(COMPILE[0]) is None:
        return None
    define = ["-DSIMD"] if simd else []
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "strokes.c"), Path(folder, "strokes.so")
        source.write_text(C_SOURCE % globals())
        subprocess.run([*COMPILE, *define, str(source), "-o", str(library), "-lm"], check=True)
        kernel = ctypes.CDLL(str(library)).strokes
    kernel.argtypes = [ctypes.c_long] + [ctypes.c_void_p] * 6
    kernel.restype = None

    def address(array: Floats) -> int:  # faster than array.ctypes.data
        return ctypes.addressof(ctypes.c_char.from_buffer(array.data))

    def strokes(x: Floats, y: Floats, phi: Floats, out: Floats) -> None:
        n, first = len(x), address(out)
        kernel(n, address(x), address(y), address(phi), first, first + 8 * n, first + 16 * n)

    return strokes
