#!/bin/sh
# usage: wasm-toolchain.sh DEST
# A compiler with a standard library for wasm32-unknown-unknown, where rustup cannot fetch one: Debian's
# Rust for web pages and its source of the standard library, built for WebAssembly. Needs apt and rustup's
# own toolchain, whose linker and cargo are used. DEST/rustc is what to use then.
set -eu
dest=$1
host=$(rustc --print sysroot)
rm -rf "$dest.new"
mkdir -p "$dest.new/debs"
dest_new=$(cd "$dest.new" && pwd)
cd "$dest_new/debs"
# A machine that is new has no lists of packages yet.
apt-cache show rustc-web >/dev/null 2>&1 || apt-get update -q
dep() { apt-cache depends "$1" | sed -n "s/.*Depends: \($2\)\$/\1/p" | head -1; }
std=$(dep libstd-rust-web-dev 'libstd-rust-web-[0-9.]*')
llvm=$(dep "$std" 'libllvm[0-9]*')
[ -n "$std" ] && [ -n "$llvm" ] || { echo "apt knows no rustc-web; run apt-get update" >&2; exit 1; }
apt-get download -q rustc-web "$std" libstd-rust-web-dev rust-web-src "$llvm"
cd ..
for deb in debs/*.deb; do
  dpkg-deb --fsys-tarfile "$deb" | tar -x --anchored --no-wildcards-match-slash \
    --exclude='./usr/share' --exclude='./usr/src/rustc-*/src' --exclude='./usr/src/rustc-*/compiler' ./usr
done
rm -rf debs
triple=$(rustc -vV | sed -n 's/^host: //p')
for so in usr/lib/*-linux-gnu/librustc_driver-*.so usr/lib/*-linux-gnu/libLLVM*.so*; do
  ln -sf "${so#usr/lib/}" usr/lib/
done
bin=lib/rustlib/$triple/bin
mkdir -p "usr/$bin"
ln -sf "$host/$bin/rust-lld" "usr/$bin/"
# Debian's compiler looks for its libraries where Debian has them.
cat > rustc <<'END'
#!/bin/sh
here=$(dirname "$0")
LD_LIBRARY_PATH=$here/usr/lib exec "$here/usr/bin/rustc" "$@"
END
chmod +x rustc
# The standard library, by building a crate that holds nothing.
mkdir -p mkstd/src
echo '#![no_std]' > mkstd/src/lib.rs
printf '[package]\nname="mkstd"\nversion="0.0.0"\nedition="2021"\n[workspace]\n' > mkstd/Cargo.toml
(cd mkstd && RUSTC="$dest_new/rustc" RUSTC_BOOTSTRAP=1 RUSTFLAGS=-Cembed-bitcode=yes \
  CARGO_TARGET_DIR=target "$host/bin/cargo" build -q --release -Zbuild-std=std,panic_abort \
  --target wasm32-unknown-unknown)
lib=usr/lib/rustlib/wasm32-unknown-unknown/lib
rm -rf $lib
mkdir -p $lib
cp mkstd/target/wasm32-unknown-unknown/release/deps/*.rlib $lib/
rm -rf $lib/libmkstd* mkstd
cd ..
rm -rf "${dest##*/}"
mv "$dest_new" "${dest##*/}"
