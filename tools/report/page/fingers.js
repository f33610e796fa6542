// Rigid fingers, drawn in their own frames (geometry/finger_shape.h), in the scene's unit of length.

import {
  BufferAttribute, BufferGeometry, CapsuleGeometry, CircleGeometry, ConeGeometry, DoubleSide, Group,
  Matrix4, Mesh, MeshPhongMaterial, SphereGeometry,
} from 'three';
import {RoundedBoxGeometry} from 'three/examples/jsm/geometries/RoundedBoxGeometry.js';
import {readArray} from './data.js';

function geometryOf(finger, size) {
  switch (finger.shape) {
    case 'sphere':
      return new SphereGeometry(finger.radius, 48, 32);
    case 'capsule':  // about the z axis
      return new CapsuleGeometry(finger.radius, finger.length, 16, 48).rotateX(Math.PI / 2);
    case 'box': {
      const [x, y, z] = finger.half_sizes.map((h) => 2 * h);
      return new RoundedBoxGeometry(x, y, z, 6, finger.rounding);
    }
    case 'plane':  // a disc of the half space z <= 0
      return new CircleGeometry(0.6 * size, 64);
    case 'pin':  // a needle whose tip is the point, from where it comes
      return new ConeGeometry(0.008 * size, 0.12 * size, 16).translate(0, -0.06 * size, 0)
          .rotateX(Math.PI / 2);
    case 'mesh': {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', new BufferAttribute(readArray(finger.points), 3));
      geometry.setIndex(new BufferAttribute(readArray(finger.indices), 1));
      const flat = geometry.toNonIndexed();
      flat.computeVertexNormals();
      return flat;
    }
    default:
      return new BufferGeometry();
  }
}

// A group that Fingers.place moves; its children are in the frame of `scale` and `center`.
export class Fingers {
  constructor(fingers, size) {
    this.fingers = fingers;
    this.group = new Group();
    this.material = new MeshPhongMaterial({
      color: 0x9aa3ad, specular: 0x333333, shininess: 40, transparent: true, opacity: 0.5,
      side: DoubleSide, depthWrite: false,
    });
    this.meshes = fingers.map((finger) => {
      const mesh = new Mesh(geometryOf(finger, size), this.material);
      const r = finger.rotation;
      mesh.setRotationFromMatrix(new Matrix4().set(
          r[0], r[1], r[2], 0, r[3], r[4], r[5], 0, r[6], r[7], r[8], 0, 0, 0, 0, 1));
      mesh.renderOrder = 2;
      this.group.add(mesh);
      return mesh;
    });
  }

  // Between the steps k and k + 1 where `part` is not 0. The way since first touch is enlarged as
  // displacements are.
  place(k, part, magnification) {
    this.fingers.forEach((finger, i) => {
      const from = finger.travel[k] ?? 0, to = finger.travel[k + 1] ?? from;
      const way = magnification * (from + part * (to - from));
      this.meshes[i].position.set(...finger.position.map((x, j) => x + way * finger.direction[j]));
    });
  }

  // [x, y, z, radius] around each where it is, in the frame of the screen. Planes are not asked to
  // be seen as a whole.
  balls(center, size) {
    return this.fingers.map((finger, i) => {
      this.meshes[i].geometry.computeBoundingSphere();
      const {radius} = this.meshes[i].geometry.boundingSphere;
      const {x, y, z} = this.meshes[i].position;
      const counts = finger.shape === 'plane' ? 0 : Math.min(radius, 0.3 * size) / size;
      return [...[x, y, z].map((v, k) => (v - center[k]) / size), counts];
    });
  }

  dispose() {
    for (const mesh of this.meshes) mesh.geometry.dispose();
    this.material.dispose();
  }
}
