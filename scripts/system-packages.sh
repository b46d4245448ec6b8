#!/bin/sh
# Installs the one thing that pip cannot: Mesa's EGL, with which pictures are rendered off-screen (no display, no GPU needed).
# Does nothing when the libraries are there. Without the right to install, prints the command to run and goes on:
# measuring needs none of it, only rendering does.
packages="libegl1 libegl-mesa0 libgl1-mesa-dri"
PATH="$PATH:/sbin:/usr/sbin"
if ldconfig -p 2>/dev/null | grep -q 'libEGL\.so\.1' && ldconfig -p 2>/dev/null | grep -q 'libEGL_mesa\.so\.0'; then
    exit 0
fi
command="apt-get install -y --no-install-recommends $packages"
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
    echo "EGL is missing; running: apt-get update && $command"
    if apt-get update -qq && DEBIAN_FRONTEND=noninteractive $command; then
        exit 0
    fi
fi
echo "EGL is missing, so pictures of simulated runs cannot be rendered yet (measuring works without it)."
echo "To install it on Debian or Ubuntu:   sudo apt-get update && sudo $command"
exit 0
