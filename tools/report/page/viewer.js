// The deformed shape in three dimensions.

import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, Group,
  LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Points,
  PointsMaterial, Raycaster, Scene, Sphere, SphereGeometry, MeshBasicMaterial, Vector2, Vector3,
  WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/examples/jsm/controls/OrbitControls.js';
import {diverging, lookUp, NO_VALUE, sequential} from './colormaps.js';
import {Cache} from './data.js';
import {innerRangeOf, merge, quantitiesOf, rangeOf} from './fields.js';
import {Fingers} from './fingers.js';

const DEFAULT_EYE = new Vector3(0.95, -1.35, 0.85);

// Edges between elements: those that no two triangles of one element share.
function elementEdges(triangles, elements) {
  const owners = new Map();  // edge -> element of the first triangle, or -1 where elements differ
  let triangle = 0;
  const count = triangles.length / 3;
  const add = (a, b, element) => {
    const key = a < b ? a * 4294967296 + b : b * 4294967296 + a;
    const owner = owners.get(key);
    owners.set(key, owner === undefined ? {element, times: 1} :
                                          {element, times: owner.element === element ? 2 : 1});
  };
  for (let element = 0; triangle < count; ++element) {
    const size = elements ? elements[element] : 4;
    for (let i = 0; i < size && triangle < count; ++i, ++triangle) {
      const [a, b, c] = triangles.subarray(3 * triangle, 3 * triangle + 3);
      add(a, b, element);
      add(b, c, element);
      add(c, a, element);
    }
  }
  const edges = [];
  for (const [key, owner] of owners) {
    if (owner.times === 1) edges.push(Math.floor(key / 4294967296), key % 4294967296);
  }
  return new Uint32Array(edges);
}

function setNormals(positions, triangles, normals) {
  normals.fill(0);
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i], b = 3 * triangles[i + 1], c = 3 * triangles[i + 2];
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1],
          uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1],
          vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const k of [a, b, c]) {
      normals[k] += x;
      normals[k + 1] += y;
      normals[k + 2] += z;
    }
  }
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i], normals[i + 1], normals[i + 2]) || 1;
    normals[i] /= length;
    normals[i + 1] /= length;
    normals[i + 2] /= length;
  }
}

export class Viewer {
  // Throws where the browser gives no WebGL.
  constructor(canvas, overlay) {
    this.canvas = canvas;
    this.overlay = overlay;
    // Asked for here: where there is none the renderer would complain in the console.
    const context = canvas.getContext('webgl2', {
      alpha: true, antialias: true, depth: true, stencil: false, premultipliedAlpha: true,
      preserveDrawingBuffer: true,
    });
    if (!context) throw new Error('no WebGL');
    this.renderer = new WebGLRenderer({canvas, context});
    // Waiting for the compiler's word takes a quarter of a second; the shaders are not ours.
    this.renderer.debug.checkShaderErrors = false;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(30, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.scene.add(new AmbientLight(0xffffff, 1.9));
    this.light = new DirectionalLight(0xffffff, 1.5);
    this.camera.add(this.light);
    this.light.position.set(0.4, 0.7, 1);
    this.scene.add(this.camera);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.draw());
    this.raycaster = new Raycaster();
    this.content = new Group();
    this.scene.add(this.content);
    this.options = {ghost: false, mesh: false, fingers: true, probes: true, cloud: true};
    this.readings = [];
    this.listeners = [];
    this.triad = this.makeTriad();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  // ---- Content ------------------------------------------------------------------------------

  show(view) {
    this.content.clear();
    this.view = view;
    this.cache = new Cache(24);
    this.rangeCache = new Map();
    this.n = view.points;
    this.rest = this.cache.read(view.rest);
    this.triangles = this.cache.read(view.indices);
    this.readings = [];
    const size = view.size > 0 ? view.size : 1;
    this.size = size;

    // Coordinates on the screen are the scene's about the centre, over its size.
    let box = null;
    const positionsOf = this.n > 0 ? this.rest : this.cache.read(view.clouds[0].points);
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < positionsOf.length; ++i) {
      low[i % 3] = Math.min(low[i % 3], positionsOf[i]);
      high[i % 3] = Math.max(high[i % 3], positionsOf[i]);
    }
    box = low.map((x, k) => 0.5 * (x + high[k]));
    this.center = box;

    const geometry = new BufferGeometry();
    const attribute = (width) => new BufferAttribute(new Float32Array(3 * this.n), width);
    this.positions = attribute(3);
    this.normals = attribute(3);
    this.colors = attribute(3);
    geometry.setAttribute('position', this.positions);
    geometry.setAttribute('normal', this.normals);
    geometry.setAttribute('color', this.colors);
    geometry.setIndex(new BufferAttribute(this.triangles, 1));
    geometry.boundingSphere = new Sphere(new Vector3(), 1e3);
    this.surface = new Mesh(geometry, new MeshLambertMaterial({
      vertexColors: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    }));
    this.surface.frustumCulled = false;
    this.content.add(this.surface);

    const ghost = new BufferGeometry();
    const restScreen = new Float32Array(3 * this.n);
    for (let i = 0; i < restScreen.length; ++i) restScreen[i] = (this.rest[i] - box[i % 3]) / size;
    const restNormals = new Float32Array(3 * this.n);
    setNormals(restScreen, this.triangles, restNormals);
    ghost.setAttribute('position', new BufferAttribute(restScreen, 3));
    ghost.setAttribute('normal', new BufferAttribute(restNormals, 3));
    ghost.setIndex(new BufferAttribute(this.triangles, 1));
    this.ghost = new Mesh(ghost, new MeshLambertMaterial({
      color: 0x8899aa, transparent: true, opacity: 0.22, depthWrite: false, side: DoubleSide,
    }));
    this.ghost.renderOrder = 3;
    this.ghost.frustumCulled = false;
    this.content.add(this.ghost);

    this.lines = null;  // made when asked for
    this.fingers = new Fingers(view.fingers, size);
    this.frame = new Group();
    this.frame.scale.setScalar(1 / size);
    this.frame.position.set(...box.map((x) => -x / size));
    this.frame.add(this.fingers.group);
    this.content.add(this.frame);

    this.clouds = view.clouds.map((cloud) => this.makeCloud(cloud));
    this.probes = view.probes.map((probe) => this.makeMarker(probe.name, 'probe'));

    this.magnification = this.naturalMagnification();
    this.time = view.steps.length - 1;
    this.setField(view.fields[0]?.name ?? '', undefined, this.rangeKind ?? 'all');
    this.resetCamera();
  }

  makeCloud(cloud) {
    const points = this.cache.read(cloud.points), values = this.cache.read(cloud.values);
    const range = innerRangeOf(values, 0.02) ?? [0, 0];
    const largest = Math.max(Math.abs(range[0]), Math.abs(range[1])) || 1;
    const positions = new Float32Array(points.length), colors = new Float32Array(points.length);
    for (let i = 0; i < points.length; ++i) {
      positions[i] = (points[i] - this.center[i % 3]) / this.size;
    }
    for (let i = 0; i < values.length; ++i) {
      if (Number.isNaN(values[i])) colors.set(NO_VALUE, 3 * i);
      else lookUp(diverging, 0.5 + (0.5 * values[i]) / largest, colors, 3 * i);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(positions, 3));
    geometry.setAttribute('color', new BufferAttribute(colors, 3));
    const object = new Points(geometry, new PointsMaterial({
      size: 2.2 * this.renderer.getPixelRatio(), sizeAttenuation: false, vertexColors: true,
    }));
    object.frustumCulled = false;
    this.content.add(object);
    return {object, range: [-largest, largest], cloud};
  }

  makeMarker(name, kind) {
    const label = document.createElement('span');
    label.className = `marker ${kind}`;
    label.textContent = name;
    this.overlay.append(label);
    const dot = new Mesh(new SphereGeometry(0.006, 16, 12), new MeshBasicMaterial({
      color: kind === 'probe' ? 0xe6007e : 0x111111,
    }));
    this.content.add(dot);
    return {label, dot};
  }

  naturalMagnification() {
    const field = this.view.fields.find((f) => f.name === 'displacement');
    if (!field) return 1;
    let largest = 0;
    for (const step of field.steps) {
      for (let k = 0; k < 3; ++k) {
        const low = step.offset[k], high = low + 65534 * step.scale[k];
        largest = Math.max(largest, Math.abs(low), Math.abs(high));
      }
    }
    // Contact would look wrong where the shape is not in proportion.
    const visible = this.view.fingers.length > 0 ? 0.002 : 0.01;
    if (!(largest > 0) || largest > visible * this.size) return 1;
    const raw = (0.08 * this.size) / largest;
    const power = 10 ** Math.floor(Math.log10(raw));
    return [5, 2, 1].find((m) => m * power <= raw) * power;
  }

  // ---- State --------------------------------------------------------------------------------

  get lastStep() {
    return this.view.steps.length - 1;
  }

  // Whole numbers are steps; what lies between is interpolated, for the eye alone.
  setTime(time) {
    this.time = Math.min(Math.max(time, 0), this.lastStep);
    this.updateShape();
    this.updateColors();
    this.draw();
  }

  setMagnification(value) {
    this.magnification = value;
    this.updateShape();
    this.draw();
  }

  setOption(name, on) {
    this.options[name] = on;
    this.draw();
  }

  // range: 'all' steps, this 'step', or 'inner', this step without its extremes.
  setField(name, key, range) {
    this.field = this.view.fields.find((f) => f.name === name) ?? null;
    if (this.field) {
      const quantities = quantitiesOf(this.field);
      this.quantity = quantities.find((q) => q.key === key) ?? quantities[0];
      // A field of the last step alone cannot be seen at another one.
      const here = this.field.steps[Math.round(this.time)];
      if (here === null) this.time = this.lastStep;
    }
    this.rangeKind = range ?? this.rangeKind;
    this.updateShape();
    this.updateColors();
    this.draw();
  }

  valuesAt(step) {
    const info = this.field.steps[step];
    return info ? this.quantity.compute(this.cache.read(info), this.n) : null;
  }

  // Interpolated between steps; null where there are none.
  valuesNow() {
    if (!this.field) return null;
    const k = Math.floor(this.time), part = this.time - k;
    const a = this.valuesAt(k), b = part > 0 ? this.valuesAt(k + 1) : null;
    if (part === 0 || !a || !b) return part > 0.5 ? b : a;
    return a.map((x, i) => x + part * (b[i] - x));
  }

  rangeNow(values) {
    let range = null;
    if (this.rangeKind === 'all') {
      const key = `${this.field.name} ${this.quantity.key}`;
      range = this.rangeCache.get(key) ?? null;
      if (range === null) {
        for (let k = 0; k <= this.lastStep; ++k) {
          const at = this.valuesAt(k);
          if (at) range = merge(range, rangeOf(at));
        }
        this.rangeCache.set(key, range);
      }
    } else if (values) {
      range = this.rangeKind === 'inner' ? innerRangeOf(values, 0.02) : rangeOf(values);
    }
    if (range === null) range = [0, 0];
    if (this.quantity.signed) {
      const largest = Math.max(Math.abs(range[0]), Math.abs(range[1]));
      range = [-largest, largest];
    } else if (range[0] > 0 && range[0] < 0.5 * range[1]) {
      range = [0, range[1]];
    }
    return range;
  }

  updateShape() {
    const field = this.view.fields.find((f) => f.name === 'displacement');
    const k = Math.floor(this.time), part = this.time - k;
    const positions = this.positions.array, rest = this.rest, {center, size} = this;
    const m = this.magnification;
    if (field) {
      const a = this.cache.read(field.steps[k]);
      const b = part > 0 ? this.cache.read(field.steps[k + 1]) : a;
      for (let i = 0; i < positions.length; ++i) {
        positions[i] = (rest[i] + m * (a[i] + part * (b[i] - a[i])) - center[i % 3]) / size;
      }
    } else {
      for (let i = 0; i < positions.length; ++i) positions[i] = (rest[i] - center[i % 3]) / size;
    }
    setNormals(positions, this.triangles, this.normals.array);
    this.positions.needsUpdate = true;
    this.normals.needsUpdate = true;
    this.fingers.place(k, part, m);
    this.view.probes.forEach((probe, i) => {
      const from = probe.displacement[k], to = probe.displacement[Math.min(k + 1, this.lastStep)];
      const u = from.map((x, j) => (x ?? 0) + part * ((to[j] ?? 0) - (x ?? 0)));
      this.probes[i].dot.position.set(
          ...probe.position.map((x, j) => (x + m * u[j] - center[j]) / size));
    });
    this.placeReadings();
  }

  updateColors() {
    const colors = this.colors.array;
    this.values = this.valuesNow();
    if (!this.field) {
      for (let i = 0; i < this.n; ++i) colors.set([0.45, 0.5, 0.55], 3 * i);
      this.range = null;
    } else {
      this.range = this.rangeNow(this.values);
      this.table = this.quantity.signed ? diverging : sequential;
      const [low, high] = this.range;
      const scale = high > low ? 1 / (high - low) : 0;
      const shift = this.quantity.signed && scale === 0 ? 0.5 : 0;
      for (let i = 0; i < this.n; ++i) {
        const value = this.values ? this.values[i] : NaN;
        if (Number.isNaN(value)) colors.set(NO_VALUE, 3 * i);
        else lookUp(this.table, shift + (value - low) * scale, colors, 3 * i);
      }
    }
    this.colors.needsUpdate = true;
    for (const listener of this.listeners) listener();
  }

  // ---- Readings -----------------------------------------------------------------------------

  // What is under a place of the canvas, in CSS pixels from its corner; null: nothing.
  pick(x, y) {
    const {width, height} = this.canvas.getBoundingClientRect();
    this.raycaster.setFromCamera(
        new Vector2((2 * x) / width - 1, 1 - (2 * y) / height), this.camera);
    const [hit] = this.raycaster.intersectObject(this.surface, false);
    if (!hit) return null;
    const corners = [hit.face.a, hit.face.b, hit.face.c];
    const p = this.positions.array;
    const at = (i) => new Vector3(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
    const [a, b, c] = corners.map(at);
    const all = b.clone().sub(a).cross(c.clone().sub(a)).length() || 1;
    const share = [
      b.clone().sub(hit.point).cross(c.clone().sub(hit.point)).length() / all,
      c.clone().sub(hit.point).cross(a.clone().sub(hit.point)).length() / all,
    ];
    return {corners, weights: [share[0], share[1], 1 - share[0] - share[1]]};
  }

  // Interpolated in the triangle: position at rest, displacement, value of the field.
  read({corners, weights}) {
    const blend = (values, width, k) =>
      weights.reduce((sum, w, i) => sum + w * values[width * corners[i] + k], 0);
    const vector = (values) => [0, 1, 2].map((k) => blend(values, 3, k));
    const field = this.view.fields.find((f) => f.name === 'displacement');
    let displacement = null;
    if (field) {
      const k = Math.floor(this.time), part = this.time - k;
      const a = vector(this.cache.read(field.steps[k]));
      const b = part > 0 ? vector(this.cache.read(field.steps[k + 1])) : a;
      displacement = a.map((x, i) => x + part * (b[i] - x));
    }
    return {
      rest: vector(this.rest), displacement,
      value: this.values ? blend(this.values, 1, 0) : null,
    };
  }

  addReading(place) {
    const reading = {place, ...this.makeMarker(String(this.readings.length + 1), 'reading')};
    this.readings.push(reading);
    this.placeReadings();
    this.draw();
  }

  clearReadings() {
    for (const reading of this.readings) {
      reading.label.remove();
      this.content.remove(reading.dot);
    }
    this.readings = [];
    this.draw();
  }

  placeReadings() {
    const p = this.positions.array;
    for (const {place, dot} of this.readings) {
      dot.position.set(...[0, 1, 2].map((k) => place.corners.reduce(
          (sum, v, i) => sum + place.weights[i] * p[3 * v + k], 0)));
    }
  }

  // ---- Camera -------------------------------------------------------------------------------

  resetCamera() {
    this.lookFrom(DEFAULT_EYE);
  }

  // Along a direction, so that all is seen: shape, undeformed shape, fingers.
  lookFrom(direction, up = [0, 0, 1]) {
    const {camera, controls} = this;
    camera.up.set(...up);
    camera.position.copy(direction).normalize().multiplyScalar(10);
    camera.lookAt(0, 0, 0);
    camera.updateMatrixWorld();
    const x = new Vector3().setFromMatrixColumn(camera.matrixWorld, 0);
    const y = new Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    const z = new Vector3().setFromMatrixColumn(camera.matrixWorld, 2);
    // Everything as points with a radius, in the frame of the camera.
    const balls = [];
    const p = new Vector3();
    const add = (px, py, pz, radius) => {
      p.set(px, py, pz);
      balls.push([p.dot(x), p.dot(y), p.dot(z), radius]);
    };
    const skip = 3 * Math.max(1, Math.floor(this.n / 4000));
    for (const values of [this.positions.array, this.ghost.geometry.attributes.position.array]) {
      for (let i = 0; i < values.length; i += skip) add(values[i], values[i + 1], values[i + 2], 0);
    }
    for (const ball of this.fingers.balls(this.center, this.size)) add(...ball);
    if (balls.length === 0) add(0, 0, 0, 0.5);
    // The middle of what is seen, then far enough away for each ball.
    const low = (k) => Math.min(...balls.map((b) => b[k] - b[3]));
    const high = (k) => Math.max(...balls.map((b) => b[k] + b[3]));
    const mid = [0, 1, 2].map((k) => 0.5 * (low(k) + high(k)));
    const tan = Math.tan((camera.fov * Math.PI) / 360), margin = 1.1;
    let distance = 0.05;
    for (const [bx, by, bz, radius] of balls) {
      const half = Math.max((Math.abs(bx - mid[0]) + radius) / camera.aspect,
                            Math.abs(by - mid[1]) + radius);
      distance = Math.max(distance, bz - mid[2] + (margin * half) / tan);
    }
    controls.target.copy(x.multiplyScalar(mid[0])).addScaledVector(y, mid[1]).addScaledVector(z, mid[2]);
    camera.position.copy(controls.target).addScaledVector(z, distance);
    controls.update();
    this.draw();
  }

  // Turns about the target, in radians.
  turn(about, upwards) {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const radius = offset.length();
    let angle = Math.atan2(offset.y, offset.x) + about;
    let height = Math.asin(offset.z / radius) + upwards;
    height = Math.min(1.56, Math.max(-1.56, height));
    offset.set(Math.cos(height) * Math.cos(angle), Math.cos(height) * Math.sin(angle),
               Math.sin(height)).multiplyScalar(radius);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  pan(right, up) {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const x = new Vector3().setFromMatrixColumn(this.camera.matrix, 0);
    const y = new Vector3().setFromMatrixColumn(this.camera.matrix, 1);
    const way = x.multiplyScalar(right * distance).add(y.multiplyScalar(up * distance));
    this.camera.position.add(way);
    this.controls.target.add(way);
    this.controls.update();
    this.draw();
  }

  zoom(factor) {
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  // ---- Drawing ------------------------------------------------------------------------------

  makeTriad() {
    const scene = new Scene();
    const geometry = new BufferGeometry();
    const ends = [], colors = [];
    const rgb = [new Color(0xd62839), new Color(0x2a9d4a), new Color(0x2667ff)];
    for (let k = 0; k < 3; ++k) {
      const end = [0, 0, 0];
      end[k] = 1;
      ends.push(0, 0, 0, ...end);
      colors.push(...rgb[k].toArray(), ...rgb[k].toArray());
    }
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(ends), 3));
    geometry.setAttribute('color', new BufferAttribute(new Float32Array(colors), 3));
    scene.add(new LineSegments(geometry, new LineBasicMaterial({vertexColors: true})));
    const labels = ['x', 'y', 'z'].map((name) => {
      const label = document.createElement('span');
      label.className = `axis ${name}`;
      label.textContent = name;
      this.overlay.append(label);
      return label;
    });
    return {scene, labels, camera: new PerspectiveCamera(30, 1, 0.1, 20)};
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    const before = this.camera.aspect;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    // What was in view stays in view.
    const fit = (aspect) => 1 / Math.min(1, aspect);
    if (this.view && before > 0) this.zoom(fit(this.camera.aspect) / fit(before));
    this.drawNow();
  }

  draw() {
    if (this.pending || !this.view) return;
    this.pending = true;
    requestAnimationFrame(() => {
      this.pending = false;
      this.drawNow();
    });
  }

  drawNow() {
    if (!this.view) return;
    const {options, renderer} = this;
    if (options.mesh && !this.lines) {
      const geometry = new BufferGeometry();
      geometry.setAttribute('position', this.positions);
      geometry.setIndex(new BufferAttribute(elementEdges(this.triangles, this.view.elements), 1));
      geometry.boundingSphere = new Sphere(new Vector3(), 1e3);
      this.lines = new LineSegments(geometry, new LineBasicMaterial({
        color: 0x000000, transparent: true, opacity: 0.38,
      }));
      this.lines.frustumCulled = false;
      this.content.add(this.lines);
    }
    if (this.lines) this.lines.visible = options.mesh;
    this.ghost.visible = options.ghost;
    this.fingers.group.visible = options.fingers;
    for (const {object} of this.clouds) {
      object.visible = options.cloud && Math.round(this.time) === this.lastStep;
    }
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    for (const {dot} of [...this.probes, ...this.readings]) {
      // Of the same size on the screen wherever they are.
      dot.scale.setScalar((this.camera.position.distanceTo(dot.position) * 540) / Math.max(300, height) / 1.5);
    }
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, width, height);
    renderer.autoClear = true;
    renderer.render(this.scene, this.camera);
    this.drawTriad(width, height);
    for (const {dot, label} of this.probes) {
      dot.visible = options.probes;
      this.placeLabel(label, dot.position, width, height, options.probes);
    }
    for (const {dot, label} of this.readings) {
      this.placeLabel(label, dot.position, width, height, true);
    }
  }

  drawTriad(width, height) {
    const {scene, labels, camera} = this.triad;
    const side = Math.min(84, 0.25 * width);
    camera.position.copy(this.camera.position).sub(this.controls.target).setLength(4.6);
    camera.up.copy(this.camera.up);
    camera.lookAt(0, 0, 0);
    this.renderer.autoClear = false;
    this.renderer.clearDepth();
    this.renderer.setViewport(6, 6, side, side);
    this.renderer.render(scene, camera);
    labels.forEach((label, k) => {
      const end = new Vector3().setComponent(k, 1.18).project(camera);
      label.style.transform = `translate(-50%, -50%) translate(${
          6 + (0.5 + 0.5 * end.x) * side}px, ${height - 6 - (0.5 + 0.5 * end.y) * side}px)`;
    });
  }

  placeLabel(label, position, width, height, visible) {
    const p = position.clone().project(this.camera);
    const inside = visible && p.z < 1 && Math.abs(p.x) < 1 && Math.abs(p.y) < 1;
    label.hidden = !inside;
    label.style.transform =
        `translate(${(0.5 + 0.5 * p.x) * width + 7}px, ${(0.5 - 0.5 * p.y) * height - 18}px)`;
  }

  clearMarkers() {
    for (const {label} of [...(this.probes ?? []), ...this.readings]) label.remove();
  }

  // The picture as it is, as a PNG.
  picture() {
    this.drawNow();
    return this.canvas.toDataURL('image/png');
  }
}
