import jax, newtonjax as nj, fitting, jax.numpy as jnp

jax.config.update("jax_enable_x64", True)
camera = nj.Camera((48, 52), pixel_size=100e-6)
scene = nj.newton_rings(2.0, 550e-9, 0.3e-6, "reflected", screen="gap")
m = fitting.measurement(scene, camera)
image = nj.render(scene, camera, nj.Chebyshev(17))
f = lambda size: m(image, pixel_size=size).numbers["radius"]
for s in (100e-6, 100.0001e-6, 100.2e-6):
    print(s, jax.grad(f)(s), jax.jvp(f, (s,), (1.0,)), (f(s + 1e-10) - f(s - 1e-10)) / 2e-10)
