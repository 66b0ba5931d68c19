"""The flight simulator written by hand in C: all twelve unknowns, velocities and accelerations.

From plane geometry, as one would write it who has a week for this one mechanism: no recursion, no
check of any kind, every division shared, arranged so that gcc vectorises the loop with the vector
sine and arc tangent of libmvec. It is what a general program can hope to come near to.
"""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path
from shutil import which

from benchmarks import baselines
from benchmarks.baselines import Floats

SOURCE = """
#include <math.h>

/* Rows of n: x, y, phi, their rates, their second rates. Rows of out: A1, A2, A3, B1.1, B1.2, B3,
   C1.1, C1.2, C3, D1, E1, E2P; then their rates; then their second rates. */
#define ROW(k, value, rate, second) \\
    out[(k) * n + i] = value; out[((k) + 12) * n + i] = rate; out[((k) + 24) * n + i] = second;

/* A universal joint at the origin and a slide from there to (x, y, z): f about z, g from z. */
#define LEG(k, x, y, z, xd, yd, zd, xe, ye, ze, home)                                  \\
    {                                                                                    \\
        const double flat2 = x * x + y * y, iflat2 = 1.0 / flat2;                        \\
        const double flat = sqrt(flat2), iflat = flat * iflat2;                          \\
        const double long2 = flat2 + z * z, ilong2 = 1.0 / long2;                        \\
        const double whole = sqrt(long2), iwhole = whole * ilong2;                       \\
        const double out_d = (x * xd + y * yd) * iflat, f_d = (x * yd - y * xd) * iflat2; \\
        const double f_e = (x * ye - y * xe - 2.0 * flat * out_d * f_d) * iflat2;        \\
        const double out_e = (x * xe + y * ye) * iflat + flat * f_d * f_d;               \\
        const double g_d = (z * out_d - flat * zd) * ilong2;                             \\
        const double l_d = (flat * out_d + z * zd) * iwhole;                             \\
        const double g_e = (z * out_e - flat * ze - 2.0 * whole * l_d * g_d) * ilong2;   \\
        const double l_e = (flat * out_e + z * ze) * iwhole + whole * g_d * g_d;         \\
        ROW(k, atan2(-x, y), f_d, f_e)                                                   \\
        ROW(k + 1, atan2(flat, z), g_d, g_e)                                             \\
        ROW(k + 2, whole - home, l_d, l_e)                                               \\
    }

void simulator(long n, const double *restrict in, double *restrict out)
{
    const double rod = %(H)r - %(D1)r, h = %(H)r, crank = %(L3)r, other = %(L4)r;
    const double irod = 1.0 / rod, half = 0.5 * %(B)r, foot = %(D2)r + %(D3)r + %(D4)r;

#pragma GCC ivdep
    for (long i = 0; i < n; i++) {
        const double x = in[i], y = in[n + i], phi = in[2 * n + i];
        const double xd = in[3 * n + i], yd = in[4 * n + i], phid = in[5 * n + i];
        const double xe = in[6 * n + i], ye = in[7 * n + i], phie = in[8 * n + i];

        /* D: where the circle of the crank meets that of the rod about G; (c, s) is the rod */
        const double u = x - (%(D2)r + %(D3)r), square = u * u + y * y, isquare = 1.0 / square;
        const double dot = 0.5 * (square + (crank * crank - rod * rod)), along = dot * isquare;
        const double across = sqrt(crank * crank * square - dot * dot) * isquare;
        const double dx = along * u - across * y, dy = along * y + across * u;
        const double c = (u - dx) * irod, s = (y - dy) * irod;
        const double inverse = 1.0 / (dx * s - dy * c);
        const double d_d = (xd * c + yd * s) * inverse;
        const double turn = -(xd * dx + yd * dy) * inverse * irod, turn2 = turn * turn;
        const double wx = xe + rod * turn2 * c + d_d * d_d * dx;
        const double wy = ye + rod * turn2 * s + d_d * d_d * dy;
        const double d_e = (wx * c + wy * s) * inverse;
        const double bend = -(wx * dx + wy * dy) * inverse * irod;
        ROW(9, atan2(dy, dx), d_d, d_e)

        /* A: from the origin to the rod's far end */
        const double ax = x - h * c, ay = y - h * s;
        const double axd = xd + h * turn * s, ayd = yd - h * turn * c;
        const double axe = xe + h * (bend * s + turn2 * c), aye = ye - h * (bend * c - turn2 * s);
        const double a2 = ax * ax + ay * ay, a = sqrt(a2), ia = a / a2;
        const double ca = ax * ia, sa = ay * ia;
        const double l_d = ca * axd + sa * ayd, a_d = (ca * ayd - sa * axd) * ia;
        const double l_e = ca * axe + sa * aye + a * a_d * a_d;
        const double a_e = (ca * aye - sa * axe - 2.0 * l_d * a_d) * ia;
        const double angle = atan2(ay, ax);
        ROW(0, angle, a_d, a_e)
        ROW(1, a - (%(S_A)r + %(L1)r), l_d, l_e)
        ROW(2, angle - atan2(s, c), a_d - turn, a_e - bend)

        /* E: where the circle of its crank meets the rod's line */
        const double px = x - %(D2)r, beside = px * s - y * c;
        const double root = sqrt(other * other - beside * beside), iroot = 1.0 / root;
        const double rest = px * c + y * s - root;
        const double ex = px - rest * c, ey = y - rest * s;
        const double kx = xd + rest * turn * s, ky = yd - rest * turn * c;
        const double e_d = (ky * c - kx * s) * iroot, rest_d = (kx * ex + ky * ey) * iroot;
        const double cross = 2.0 * rest_d * turn, e_d2 = e_d * e_d;
        const double mx = xe + e_d2 * ex + rest * (bend * s + turn2 * c) + cross * s;
        const double my = ye + e_d2 * ey - rest * (bend * c - turn2 * s) - cross * c;
        ROW(10, atan2(ey, ex), e_d, (my * c - mx * s) * iroot)
        ROW(11, rod - rest, -rest_d, -(mx * ex + my * ey) * iroot)

        /* B and C: to the ends of the arm through G, across the rod and turned about it by phi */
        const double sp = half * sin(phi), cp = half * sin(phi + 1.5707963267948966);
        const double spd = cp * phid, cpd = -sp * phid;
        const double spe = cp * phie + cpd * phid, cpe = -sp * phie - spd * phid;
        const double cd = -s * turn, ce = -s * bend - c * turn2;
        const double sd = c * turn, se = c * bend - s * turn2;
        const double vx = sp * s, vxd = spd * s + sp * sd;
        const double vy = -sp * c, vyd = -spd * c - sp * cd;
        const double vxe = spe * s + 2.0 * spd * sd + sp * se;
        const double vye = -spe * c - 2.0 * spd * cd - sp * ce;
        const double z = %(D5)r - cp, zd = -cpd, ze = -cpe;
        const double bx = x - foot + vx, by = y + vy, bxd = xd + vxd, byd = yd + vyd;
        const double bxe = xe + vxe, bye = ye + vye;
        LEG(3, bx, by, z, bxd, byd, zd, bxe, bye, ze, (%(S_B)r + %(L2)r))
        const double gx = x - foot - vx, gy = y - vy, gxd = xd - vxd, gyd = yd - vyd;
        const double gxe = xe - vxe, gye = ye - vye;
        LEG(6, gx, gy, z, gxd, gyd, zd, gxe, gye, ze, (%(S_C)r + %(L2)r))
    }
}
"""
COMPILE = (*("gcc", "-O3", "-march=native", "-ffast-math", "-fopenmp-simd", "-shared", "-fPIC"),)


def build_by_hand() -> Callable[[Floats, Floats], None] | None:
    """A function (in, out) from rows (9, n) to rows (36, n); None without gcc. The arrays are
    float64, contiguous and writable.
    """
    if which(COMPILE[0]) is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        source, library = Path(folder, "simulator.c"), Path(folder, "simulator.so")
        source.write_text(SOURCE % vars(baselines))
        subprocess.run([*COMPILE, str(source), "-o", str(library), "-lm"], check=True)
        kernel = ctypes.CDLL(str(library)).simulator
    kernel.argtypes = [ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
    kernel.restype = None

    def simulator(inputs: Floats, out: Floats) -> None:
        kernel(inputs.shape[1], inputs.ctypes.data, out.ctypes.data)

    return simulator
