#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Set up a Blender that has windows, for tests/window and `make manual-pictures`, where a machine has none.
#
#   sudo tools/window_blender.sh FOLDER      then  LAMINA_BLENDER=FOLDER/blender make manual-pictures
#
# Debian's unstable Blender (5.2, without OSL) goes into a system of its own in FOLDER/root, about 3 GB; FOLDER/blender starts it, with the
# folders of this machine that it needs. Needs Linux, root and debootstrap; goes on where it was stopped. To remove it: rm -r FOLDER.
set -euo pipefail
[ $# = 1 ] || { sed -n 3,9p "$0" >&2; exit 2; }
[ "$(id -u)" = 0 ] || { echo "lamina: $0 needs root, for a file system of its own" >&2; exit 2; }
command -v debootstrap >/dev/null || { echo "lamina: missing debootstrap. On Debian: apt-get install debootstrap" >&2; exit 2; }
mkdir -p "$1"
folder=$(cd "$1" && pwd)
root=$folder/root

if [ ! -e "$folder/base-is-there" ]; then
  rm -rf --one-file-system "$root"
  debootstrap --variant=minbase sid "$root" >"$folder/debootstrap.log"
  touch "$folder/base-is-there"
fi

# FOLDER/inside COMMAND...: inside, with the display, the variables and the folders that tests hand over
cat >"$folder/inside" <<'INSIDE'
#!/usr/bin/env bash
root=$(dirname "$(readlink -f "$0")")/root
here=$PWD
keep=(PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 LIBGL_ALWAYS_SOFTWARE=1 SDL_AUDIODRIVER=dummy)
while IFS= read -r line; do keep+=("$line"); done < <(env | grep -E '^(DISPLAY|LAMINA_[A-Z]*|BLENDER_USER_RESOURCES|https?_proxy)=' || true)
for seen in /tmp "$here"; do
  [ "$seen" = / ] || { mkdir -p "$root$seen"; binds+=("$seen"); }
done
export root
exec unshare -m bash -c '
  mount --bind /proc "$root/proc"; mount --bind /dev "$root/dev"; mount --bind /sys "$root/sys"
  count=$1; shift
  for ((i = 0; i < count; i++)); do mount --rbind "$1" "$root$1"; shift; done
  exec chroot "$root" /usr/bin/env -i -C "$@"' inside "${#binds[@]}" "${binds[@]}" "$here" "${keep[@]}" "$@"
INSIDE
printf '#!/usr/bin/env bash\nexec "$(dirname "$(readlink -f "$0")")/inside" blender "$@"\n' >"$folder/blender"
chmod +x "$folder/inside" "$folder/blender"

cp -L /etc/resolv.conf "$root/etc/resolv.conf"
packages="blender ca-certificates fonts-dejavu-core libgl1 libgl1-mesa-dri libglx-mesa0 libegl-mesa0 python3-numpy python3-openimageio python3-requests python3-zstandard python3-pip"
if ! "$folder/inside" dpkg-query -W blender >/dev/null 2>&1; then
  # A mirror may be a snapshot, whose list of releases is out of date.
  "$folder/inside" apt-get -o Acquire::Check-Valid-Until=false update -qq
  "$folder/inside" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages >"$folder/apt.log"
fi
# What this machine trusts, as its network may have a certificate of its own.
cp -L /etc/ssl/certs/ca-certificates.crt "$root/etc/ssl/certs/"
# Debian has no cattrs, without which Blender's extensions do not register
"$folder/inside" python3 -c 'import cattrs' 2>/dev/null ||
  "$folder/inside" python3 -m pip install -q --break-system-packages --root-user-action ignore cattrs==25.1.1
"$folder/blender" --version | head -1
