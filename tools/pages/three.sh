#!/bin/sh
# Makes voronec/motion/viewer/three.min.js, the parts of three.js that pages use, from the npm
# registry: run it where a newer three.js is wanted.  It needs npm; who uses voronec does not.
set -eu
here=$(cd "$(dirname "$0")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
cd "$work"
npm init -y > /dev/null
npm install --silent three@0.187.0 esbuild@0.28.2
cat > entry.js <<'END'
export {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group, HemisphereLight, Mesh,
  MeshLambertMaterial, PerspectiveCamera, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from "three";
END
npx esbuild entry.js --bundle --minify --format=iife --global-name=THREE --legal-comments=none \
  --target=es2020 --outfile=three.min.js
target="$here/voronec/motion/viewer/three.min.js"
{
  echo "/*"
  echo "three.js 0.187.0, the parts that voronec's pages use; made by tools/pages/three.sh"
  cat node_modules/three/LICENSE
  echo "*/"
  cat three.min.js
} > "$target"
