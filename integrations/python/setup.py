"""One wheel for all versions of Python 3: the extension module keeps to the stable ABI."""
import platform

from setuptools import Distribution, setup


class BinaryDistribution(Distribution):
    def has_ext_modules(self):
        return True


# of the C library that it was linked to, which must not be older where it is installed (PEP 600)
version = platform.libc_ver()[1].replace(".", "_")
setup(distclass=BinaryDistribution, options={"bdist_wheel": {
    "py_limited_api": "cp38", "plat_name": f"manylinux_{version}_{platform.machine()}"}})
