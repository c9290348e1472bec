"""Other ways to the same image, for timing beside ours: batoid, and hand-written traces in numba and in Dr.Jit.

All follow the two beams of the default Newton's-rings bench seen in transmission, from every pixel's launch point. None
of the peers aims (the launch point is the pixel's own place), which spares them the search that our rays have behind
them; at 1024 x 1024 and 5 um their phases are then 0.06 turns off in the corners.
Each maker returns a function without arguments, or None where the library is not installed.
"""

import numpy as np

# The bench: lens flat 0, lens convex 1, plate upper 2, plate lower 3 (T: transmit, R: reflect), indices, heights [m].
WORDS = (((0, 0), (1, 0), (2, 0), (3, 0)), ((0, 0), (1, 0), (2, 1), (1, 1), (2, 0), (3, 0)))
MEDIA = (1.0, 1.5, 1.0, 1.5, 1.0)
HEIGHTS = (5e-3, 0.0, 0.0, -5e-3)
SCREEN = -6e-3


def _table(radius: float):
    """Rows of numbers per interaction: height, curvature, index before, index beyond, reflects (and -1 for no more)."""
    table = np.full((2, 6, 5), -1.0)
    for beam, word in enumerate(WORDS):
        medium, down = 0, True
        for k, (surface, reflects) in enumerate(word):
            beyond = medium + 1 if down else medium - 1
            curvature = 1 / radius if surface == 1 else 0.0
            table[beam, k] = HEIGHTS[surface], curvature, MEDIA[medium], MEDIA[beyond], reflects
            medium, down = (medium, not down) if reflects else (beyond, down)
    return table


def _axis(count: int, pixel: float) -> np.ndarray:
    return (np.arange(count) - (count - 1) / 2) * pixel


def batoid_paths(count: int, pixel: float, radius: float):
    """Optical paths of both beams at count² launch points, by batoid (paths only: no field, no image)."""
    try:
        import batoid
    except ImportError:
        return None
    surfaces = [batoid.Plane(), batoid.Sphere(radius), batoid.Plane(), batoid.Plane()]
    systems = [batoid.CoordSys(origin=[0, 0, z]) for z in HEIGHTS]
    media = [batoid.ConstMedium(n) for n in MEDIA]
    screen, plane = batoid.CoordSys(origin=[0, 0, SCREEN]), batoid.Plane()
    x, y = np.meshgrid(_axis(count, pixel), _axis(count, pixel))
    x, y = x.ravel(), y.ravel()
    zero = np.zeros_like(x)

    def paths():
        out = []
        for word in WORDS:
            rays = batoid.RayVector(x, y, zero + 6e-3, zero, zero, zero - 1.0, 0.0, 500e-9, 1.0)
            medium, down = 0, True
            for surface, reflects in word:
                beyond = medium + 1 if down else medium - 1
                if reflects:
                    batoid.reflect(surfaces[surface], rays, coordSys=systems[surface])
                    down = not down
                else:
                    batoid.refract(surfaces[surface], rays, media[medium], media[beyond], coordSys=systems[surface])
                    medium = beyond
            batoid.intersect(plane, rays, coordSys=screen)
            out.append(rays.t)
        return out

    return paths


def numba_image(count: int, pixel: float, radius: float, wavelength: float):
    """The image by one loop over pixels: intersections, Snell, Fresnel s and p, two beams, and a cosine; parallel."""
    try:
        import numba
    except ImportError:
        return None
    table, x, turn = _table(radius), _axis(count, pixel), 2 * np.pi / wavelength

    @numba.njit(fastmath=False, error_model="numpy")
    def beam(stops, x, y):
        z, dx, dy, dz, path, s, p = 6e-3, 0.0, 0.0, -1.0, 0.0, 1.0, 1.0
        for k in range(stops.shape[0]):
            height, c, n1, n2, reflects = stops[k, 0], stops[k, 1], stops[k, 2], stops[k, 3], stops[k, 4]
            if n1 < 0:
                break
            slide = (height - z) / dz
            ox, oy = x + slide * dx, y + slide * dy
            b = c * (ox * dx + oy * dy) - dz
            rho2 = ox * ox + oy * oy
            root = np.sqrt(b * b - c * c * rho2)
            length = slide + c * rho2 / ((root if dz > 0 else -root) - b)
            x, y, z = x + length * dx, y + length * dy, z + length * dz
            path += n1 * length
            nx, ny, nz = -c * x, -c * y, 1 - c * (z - height)
            if nx * dx + ny * dy + nz * dz > 0:
                nx, ny, nz = -nx, -ny, -nz
            cos_i = -(nx * dx + ny * dy + nz * dz)
            eta = n1 / n2
            cos_t = np.sqrt(1 - eta * eta * (1 - cos_i * cos_i))
            if reflects > 0:
                s *= (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t)
                p *= (n1 * cos_t - n2 * cos_i) / (n2 * cos_i + n1 * cos_t)
                dx, dy, dz = dx + 2 * cos_i * nx, dy + 2 * cos_i * ny, dz + 2 * cos_i * nz
            else:
                scale = np.sqrt(n2 * cos_t / (n1 * cos_i))
                s *= scale * 2 * n1 * cos_i / (n1 * cos_i + n2 * cos_t)
                p *= scale * 2 * n1 * cos_i / (n2 * cos_i + n1 * cos_t)
                along = eta * cos_i - cos_t
                dx, dy, dz = eta * dx + along * nx, eta * dy + along * ny, eta * dz + along * nz
        return path + (SCREEN - z) / dz, s, p

    @numba.njit(parallel=True, fastmath=False, error_model="numpy")
    def image(table, x, turn):
        out = np.empty((x.size, x.size))
        for row in numba.prange(x.size):
            for column in range(x.size):
                path1, s1, p1 = beam(table[0], x[column], x[row])
                path2, s2, p2 = beam(table[1], x[column], x[row])
                fringes = np.cos(turn * (path2 - path1)) * (s1 * s2 + p1 * p2)
                out[row, column] = (s1 * s1 + p1 * p1 + s2 * s2 + p2 * p2) / 2 + fringes
        return out

    return lambda: image(table, x, turn)


def drjit_image(count: int, pixel: float, radius: float, wavelength: float):
    """The same loop as `numba_image`, unrolled over interactions and traced by Dr.Jit's LLVM backend."""
    try:
        import drjit as dr
        from drjit.llvm import Float64, UInt32

        dr.eval(Float64(1.0))
    except (ImportError, RuntimeError, AttributeError):
        return None
    table, middle = _table(radius).tolist(), (count - 1) / 2

    def beam(stops, x, y, c_lens):
        z, dx, dy, dz, path, s, p = Float64(6e-3), Float64(0.0), Float64(0.0), Float64(-1.0), Float64(0.0), 1.0, 1.0
        for height, curvature, n1, n2, reflects in stops:
            if n1 < 0:
                break
            c = c_lens if curvature else 0.0
            slide = (height - z) / dz
            ox, oy = x + slide * dx, y + slide * dy
            b = c * (ox * dx + oy * dy) - dz
            rho2 = ox * ox + oy * oy
            root = dr.sqrt(b * b - c * c * rho2)
            length = slide + c * rho2 / (dr.select(dz > 0, root, -root) - b)
            x, y, z = x + length * dx, y + length * dy, z + length * dz
            path += n1 * length
            nx, ny, nz = -c * x, -c * y, 1 - c * (z - height)
            sign = dr.select(nx * dx + ny * dy + nz * dz > 0, Float64(-1.0), Float64(1.0))
            nx, ny, nz = sign * nx, sign * ny, sign * nz
            cos_i = -(nx * dx + ny * dy + nz * dz)
            eta = n1 / n2
            cos_t = dr.sqrt(1 - eta * eta * (1 - cos_i * cos_i))
            if reflects > 0:
                s = s * (n1 * cos_i - n2 * cos_t) / (n1 * cos_i + n2 * cos_t)
                p = p * (n1 * cos_t - n2 * cos_i) / (n2 * cos_i + n1 * cos_t)
                dx, dy, dz = dx + 2 * cos_i * nx, dy + 2 * cos_i * ny, dz + 2 * cos_i * nz
            else:
                scale = dr.sqrt(n2 * cos_t / (n1 * cos_i))
                s = s * scale * 2 * n1 * cos_i / (n1 * cos_i + n2 * cos_t)
                p = p * scale * 2 * n1 * cos_i / (n2 * cos_i + n1 * cos_t)
                along = eta * cos_i - cos_t
                dx, dy, dz = eta * dx + along * nx, eta * dy + along * ny, eta * dz + along * nz
        return path + (SCREEN - z) / dz, s, p

    def image():
        index = dr.arange(UInt32, count * count)
        x = (Float64(index % count) - middle) * pixel
        y = (Float64(index // count) - middle) * pixel
        # Opaque: the numbers stay arguments of the kernel, as they are in ours.
        c_lens, turn = dr.opaque(Float64, 1 / radius), dr.opaque(Float64, 2 * np.pi / wavelength)
        path1, s1, p1 = beam(table[0], x, y, c_lens)
        path2, s2, p2 = beam(table[1], x, y, c_lens)
        out = (s1 * s1 + p1 * p1 + s2 * s2 + p2 * p2) / 2 + dr.cos(turn * (path2 - path1)) * (s1 * s2 + p1 * p2)
        dr.eval(out)
        dr.sync_thread()
        return out

    return image
