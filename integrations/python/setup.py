"""One wheel for all versions of Python 3: the extension module keeps to the stable ABI."""
import platform

from setuptools import Distribution, setup


class BinaryDistribution(Distribution):
    def has_ext_modules(self):
        return True


# The platform names the version of the C library that it was linked to, which must not be older where it is installed
# (PEP 600). The tag names an older Python than pyproject.toml does: so pip can tell 3.6 and 3.7 that they are too old,
# not just that the wheel is for another platform.
version = platform.libc_ver()[1].replace(".", "_")
setup(distclass=BinaryDistribution, options={"bdist_wheel": {
    "py_limited_api": "cp36", "plat_name": f"manylinux_{version}_{platform.machine()}"}})
