/** The mesh in its light, and the camera that goes round it. */
import * as three from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import type { View } from "../api/types";
import { coarser } from "../geometry/coarse";
import { normals } from "../geometry/normals";
import type { Surface } from "../geometry/surface";
import { isStill } from "../state/preferences";

/** The angle of the camera's view, in degrees: narrow, since drawings have little perspective. */
const ANGLE = 24;
/** How much of the picture the mesh fills when the camera is put in its place. */
const FILLED = 0.9;
/** How far from its middle the mesh may be posed and still be hit by the pointer, in radii of the ball round it at rest. */
const REACH = 4;
/** How long the camera takes to another view, in ms. */
const FLIGHT = 500;

/** Triangles that a processor draws of a mesh while it moves, about, and how long it rests until all are drawn, in ms. */
const MOVING = 20_000;
const REST = 150;

/** What draws where there is no graphics card: of Chromium, of Mesa, of Windows. */
const PROCESSORS = /SwiftShader|llvmpipe|softpipe|Basic Render/i;

/** Whether a graphics card draws: a processor takes as long over smooth edges as over all the rest of a picture. */
function hasGraphicsCard(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const name = info && context?.getParameter(info.UNMASKED_RENDERER_WEBGL);
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return !PROCESSORS.test(String(name));
}

export class Stage {
  private readonly renderer: three.WebGLRenderer;
  private readonly scene = new three.Scene();
  private readonly camera = new three.PerspectiveCamera(ANGLE, 1, 0.01, 100);
  private readonly material = new three.MeshLambertMaterial({ vertexColors: true, side: three.DoubleSide });
  private readonly body = new three.Mesh(new three.BufferGeometry(), this.material);
  private controls: OrbitControls;
  private readonly isProcessor = !hasGraphicsCard();
  /** All triangles, and fewer to draw while the mesh moves. */
  private all: three.BufferAttribute | null = null;
  private few: three.BufferAttribute | null = null;
  private resting = 0;
  /** The places of the mesh that is shown, as they came. */
  private rest: Float32Array | null = null;
  private isAsked = false;
  private isRecoloured = false;
  private flight = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    /** Told whenever the picture has changed: what lies over it has to follow. */
    private readonly drawn: () => void,
  ) {
    this.renderer = new three.WebGLRenderer({ canvas, antialias: !this.isProcessor, alpha: true });
    const headlight = new three.DirectionalLight(0xffffff, 1.9);
    headlight.position.set(-0.4, 0.7, 1);
    this.camera.add(headlight);
    this.scene.add(this.camera, this.body, new three.AmbientLight(0xffffff, 1.5));
    this.camera.position.set(2, 1.2, 4);
    this.controls = this.steered();
  }

  show(surface: Surface) {
    const geometry = new three.BufferGeometry();
    const places = new three.BufferAttribute(surface.positions.slice(), 3).setUsage(three.DynamicDrawUsage);
    geometry.setAttribute("position", places);
    this.rest = surface.positions;
    this.all = new three.BufferAttribute(surface.triangles, 1);
    const isMuch = this.isProcessor && surface.triangles.length > 3 * MOVING;
    this.few = isMuch ? new three.BufferAttribute(coarser(surface, MOVING), 1) : null;
    geometry.setIndex(this.all);
    geometry.computeVertexNormals();
    geometry.setAttribute("color", new three.BufferAttribute(new Float32Array(surface.positions.length).fill(0.7), 3));
    this.body.geometry.dispose();
    this.body.geometry = geometry;
    this.center(surface);
  }

  colour(light: Float32Array) {
    if (light.length !== this.body.geometry.getAttribute("position")?.array.length) return;
    this.body.geometry.setAttribute("color", new three.BufferAttribute(light, 3));
    this.isRecoloured = true;
    this.ask();
  }

  /** Takes the vertices to other places: the camera stays. */
  move(positions: Float32Array) {
    const places = this.body.geometry.getAttribute("position");
    if (positions.length !== places?.array.length) return;
    places.array.set(positions);
    places.needsUpdate = true;
    const normal = this.body.geometry.getAttribute("normal");
    normals(positions, this.all?.array as Uint32Array, normal.array as Float32Array);
    normal.needsUpdate = true;
    if (positions !== this.rest) this.coarsen();
    this.ask();
  }

  /** Draws few triangles until the mesh has rested. */
  private coarsen() {
    if (!this.few) return;
    clearTimeout(this.resting);
    this.body.geometry.setIndex(this.few);
    this.resting = window.setTimeout(() => {
      this.body.geometry.setIndex(this.all);
      this.ask();
    }, REST);
  }

  /** Puts the camera so that the mesh is seen from this view. */
  look({ toward_camera, up }: View, isFlown = true) {
    cancelAnimationFrame(this.flight);
    const target = new three.Object3D();
    target.up.fromArray(up);
    // A camera looks along its −z, an object along its +z.
    target.lookAt(new three.Vector3().fromArray(toward_camera));
    const [from, distance] = [this.camera.quaternion.clone(), this.camera.position.distanceTo(this.controls.target)];
    const [start, end] = [performance.now(), this.distance()];
    const length = isFlown && !isStill() ? FLIGHT : 0;
    const fly = () => {
      const share = length === 0 ? 1 : Math.min(1, (performance.now() - start) / length);
      const eased = share * share * (3 - 2 * share);
      this.camera.quaternion.slerpQuaternions(from, target.quaternion, eased);
      const back = new three.Vector3(0, 0, distance + eased * (end - distance)).applyQuaternion(this.camera.quaternion);
      this.camera.position.copy(back);
      this.camera.up.set(0, 1, 0).applyQuaternion(this.camera.quaternion);
      if (share < 1) this.flight = requestAnimationFrame(fly);
      else this.land(up);
      this.ask();
    };
    this.controls.enabled = false;
    fly();
  }

  /** Turns the camera by angles round the mesh: to the right and upward, in turns. */
  turn(right: number, upward: number) {
    const around = new three.Spherical().setFromVector3(this.camera.position.clone().applyQuaternion(this.standing()));
    around.theta += 2 * Math.PI * right;
    around.phi = Math.min(Math.PI - 1e-3, Math.max(1e-3, around.phi - 2 * Math.PI * upward));
    this.camera.position.setFromSpherical(around).applyQuaternion(this.standing().invert());
    this.controls.update();
    this.ask();
  }

  zoom(factor: number) {
    this.camera.position.multiplyScalar(factor);
    this.controls.update();
    this.ask();
  }

  /** The vertex nearest to what is seen at a point of the canvas, in its pixels; nothing beside the mesh. */
  pick(x: number, y: number): number | null {
    const { clientWidth, clientHeight } = this.canvas;
    const ray = new three.Raycaster();
    ray.setFromCamera(new three.Vector2((2 * x) / clientWidth - 1, 1 - (2 * y) / clientHeight), this.camera);
    const hit = ray.intersectObject(this.body)[0];
    if (!hit?.face) return null;
    const at = this.body.worldToLocal(hit.point.clone());
    const away = (v: number) => this.vertex(v).distanceToSquared(at);
    return [hit.face.a, hit.face.b, hit.face.c].reduce((near, v) => (away(v) < away(near) ? v : near));
  }

  /** Where a vertex is on the canvas, in its pixels, and whether the surface faces away from the camera there. */
  place(vertex: number): { x: number; y: number; isBehind: boolean } {
    const at = this.body.localToWorld(this.vertex(vertex));
    const normal = new three.Vector3().fromBufferAttribute(this.body.geometry.getAttribute("normal"), vertex);
    const isBehind = normal.dot(this.camera.position.clone().sub(at)) < 0;
    const { x, y } = at.project(this.camera);
    return { x: ((x + 1) / 2) * this.canvas.clientWidth, y: ((1 - y) / 2) * this.canvas.clientHeight, isBehind };
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  dispose() {
    cancelAnimationFrame(this.flight);
    clearTimeout(this.resting);
    this.controls.dispose();
    this.body.geometry.dispose();
    this.material.dispose();
    this.renderer.dispose();
  }

  /** Moves the mesh so that the middle of its box is the origin, and makes the ball round it one of radius 1. */
  private center(surface: Surface) {
    const box = new three.Box3();
    for (const v of surface.triangles) box.expandByPoint(this.vertex(v));
    const middle = box.getCenter(new three.Vector3());
    const radius = box.getSize(new three.Vector3()).length() / 2 || 1;
    this.body.scale.setScalar(1 / radius);
    this.body.position.copy(middle).multiplyScalar(-1 / radius);
    this.body.updateMatrixWorld();
    // Not computed by three: vertices of no triangle may lie anywhere.
    this.body.geometry.boundingSphere = new three.Sphere(middle, REACH * radius);
  }

  private vertex(v: number): three.Vector3 {
    return new three.Vector3().fromBufferAttribute(this.body.geometry.getAttribute("position"), v);
  }

  /** How far off the camera sees the whole ball. */
  private distance(): number {
    const narrower = Math.min(1, this.camera.aspect);
    return 1 / (FILLED * narrower * Math.tan((ANGLE * Math.PI) / 360));
  }

  /** The rotation that makes the camera's up the y axis. */
  private standing(): three.Quaternion {
    return new three.Quaternion().setFromUnitVectors(this.camera.up, new three.Vector3(0, 1, 0));
  }

  private land(up: number[]) {
    this.camera.up.fromArray(up);
    this.controls.dispose();
    this.controls = this.steered();
  }

  /** Controls that keep the camera's up: they take it when they are made. */
  private steered(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.enablePan = false;
    [controls.minDistance, controls.maxDistance] = [1.2, 20];
    controls.addEventListener("change", () => this.ask());
    return controls;
  }

  private ask() {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame(() => {
      this.isAsked = false;
      this.renderer.render(this.scene, this.camera);
      this.drawn();
      // What `npm run measure` looks for.
      if (this.isRecoloured) performance.mark("coloured");
      this.isRecoloured = false;
    });
  }
}
