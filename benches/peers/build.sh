#!/bin/sh
# Builds the peers whose libraries are installed, into target/peers/bin, and says which are not.
# Optimised as their documentation asks for (-O3 -DNDEBUG) and, like fairform, for any processor of
# the architecture: no -march.
set -eu
cd "$(dirname "$0")"
bin=../../target/peers/bin
mkdir -p "$bin"
flags="-std=c++17 -O3 -DNDEBUG -Wall -Wextra -Wno-maybe-uninitialized"

# build NAME HEADER FLAGS...: the headers of a library as those of the system, without warnings.
build() {
  name=$1 header=$2
  shift 2
  if ! echo "#include <$header>" | ${CXX:-g++} $flags -fsyntax-only -w -x c++ - "$@" 2>/dev/null; then
    echo "$name: not installed ($header)"
    rm -f "$bin/$name"
    return
  fi
  if [ "$bin/$name" -nt "$name.cpp" ] && [ "$bin/$name" -nt peer.hpp ]; then return; fi
  ${CXX:-g++} $flags "$name.cpp" -o "$bin/$name" "$@"
  echo "$name: built"
}

build opensubdiv opensubdiv/version.h -losdCPU
build openmesh OpenMesh/Core/System/config.h -lOpenMeshCore -lOpenMeshTools
build cgal CGAL/subdivision_method_3.h -lgmp -lmpfr
build cholmod suitesparse/cholmod.h -I/usr/include/suitesparse -lcholmod
