#!/bin/sh
# Installs the libraries that fairform is compared with: from Debian's packages, and from PyPI into an
# environment of its own in target/peers/venv. What cannot be had is named and left out; nothing that
# fairform needs is installed here.
set -u
cd "$(dirname "$0")/../.."
if [ "$(id -u)" = 0 ]; then sudo=; else sudo=sudo; fi

$sudo apt-get update
# One by one, so that a missing package does not keep the others away. CHOLMOD is as fast as the BLAS
# below it, so that is OpenBLAS and not the reference. The last line is what Open3D loads.
for package in g++ libosd-dev libopenmesh-dev libcgal-dev libsuitesparse-dev libopenblas-dev \
  python3 python3-venv \
  libusb-1.0-0 libgl1 libgomp1; do
  $sudo env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y --no-install-recommends "$package" || echo "left out: $package"
done

# Debian's own Python: a wheel is looked for by its version.
/usr/bin/python3 -m venv target/peers/venv
for package in trimesh scipy libigl vtk open3d-cpu; do
  target/peers/venv/bin/pip install --quiet "$package" || echo "left out: $package"
done
