// SPDX-License-Identifier: Apache-2.0
// The shapes of a robot description, as polygons.
import {IDENTITY, apply, fromRpy} from './geometry.js';

const ROUND = 16; // corners of a circle
const GREY = [0.55, 0.57, 0.6, 1];

/** Returns {name, links: [{name, visuals, collisions}], joints: [{child, parent, pose}]} of a parsed XML document. A shape is {pose, colour,
 * kind, ...}. */
export function readUrdf(document) {
  const robot = document.documentElement;
  if (!robot || robot.tagName !== 'robot') throw new Error('the description is no URDF');
  const materials = new Map();
  for (const material of childrenOf(robot, 'material')) materials.set(material.getAttribute('name'), colourOf(material));
  const links = childrenOf(robot, 'link').map((link) => ({
    name: link.getAttribute('name'),
    visuals: childrenOf(link, 'visual')
      .map((visual) => shapeOf(visual, materials))
      .filter(Boolean),
    collisions: childrenOf(link, 'collision')
      .map((collision) => shapeOf(collision, materials))
      .filter(Boolean),
  }));
  const joints = childrenOf(robot, 'joint').map((joint) => ({
    parent: child(joint, 'parent')?.getAttribute('link'),
    child: child(joint, 'child')?.getAttribute('link'),
    pose: originOf(joint),
  }));
  return {name: robot.getAttribute('name') ?? '', links, joints};
}

function childrenOf(element, name) {
  return Array.from(element.children).filter((one) => one.tagName === name);
}
function child(element, name) {
  return childrenOf(element, name)[0];
}
function numbers(text, fallback) {
  const values = (text ?? '').trim().split(/\s+/).map(Number);
  return values.length === fallback.length && values.every(Number.isFinite) ? values : fallback;
}
function originOf(element) {
  const origin = child(element, 'origin');
  if (!origin) return IDENTITY;
  return {p: numbers(origin.getAttribute('xyz'), [0, 0, 0]), q: fromRpy(numbers(origin.getAttribute('rpy'), [0, 0, 0]))};
}
function colourOf(material) {
  const colour = child(material, 'color');
  return colour ? numbers(colour.getAttribute('rgba'), GREY) : null;
}

function shapeOf(element, materials) {
  const geometry = child(element, 'geometry')?.children[0];
  if (!geometry) return null;
  const material = child(element, 'material');
  const colour = (material && (colourOf(material) ?? materials.get(material.getAttribute('name')))) || GREY;
  const number = (name) => Number(geometry.getAttribute(name)) || 0;
  const common = {kind: geometry.tagName, pose: originOf(element), colour};
  switch (geometry.tagName) {
    case 'box':
      return {...common, size: numbers(geometry.getAttribute('size'), [0, 0, 0])};
    case 'cylinder':
      return {...common, radius: number('radius'), length: number('length')};
    case 'sphere':
      return {...common, radius: number('radius')};
    case 'mesh':
      return {...common, uri: geometry.getAttribute('filename') ?? '', scale: numbers(geometry.getAttribute('scale'), [1, 1, 1])};
    default:
      return null;
  }
}

/** Returns the faces of a shape in its link: arrays of corners [x, y, z]. A mesh has `triangles` when it was fetched; before that it has none. */
export function facesOf(shape) {
  const faces = {box: boxFaces, cylinder: cylinderFaces, sphere: sphereFaces, mesh: meshFaces}[shape.kind](shape);
  return faces.map((face) => face.map((corner) => apply(shape.pose, corner)));
}

function boxFaces({size}) {
  const [x, y, z] = size.map((length) => length / 2);
  const corner = (i) => [i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z];
  return [
    [0, 2, 3, 1],
    [4, 5, 7, 6],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 4, 6, 2],
    [1, 3, 7, 5],
  ].map((face) => face.map(corner));
}

function ring(radius, z) {
  return Array.from({length: ROUND}, (_, i) => [radius * Math.cos((2 * Math.PI * i) / ROUND), radius * Math.sin((2 * Math.PI * i) / ROUND), z]);
}

/** The faces between two rings of as many corners. */
function mantle(low, high) {
  return low.map((corner, i) => [corner, low[(i + 1) % ROUND], high[(i + 1) % ROUND], high[i]]);
}

function cylinderFaces({radius, length}) {
  const low = ring(radius, -length / 2);
  const high = ring(radius, length / 2);
  return [[...low].reverse(), high, ...mantle(low, high)];
}

function sphereFaces({radius}) {
  const rings = Array.from({length: 9}, (_, i) => {
    const angle = Math.PI * (i / 8 - 0.5);
    return ring(Math.max(1e-6, radius * Math.cos(angle)), radius * Math.sin(angle));
  });
  return rings.slice(1).flatMap((high, i) => mantle(rings[i], high));
}

function meshFaces({triangles = [], scale}) {
  return triangles.map((face) => face.map((corner) => corner.map((part, i) => part * scale[i])));
}

/** Returns the triangles of a binary STL file; throws an Error if it is none. */
export function readStl(bytes, most = 20000) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const count = bytes.length >= 84 ? view.getUint32(80, true) : -1;
  if (count < 0 || bytes.length < 84 + 50 * count) throw new Error('no binary STL');
  const step = Math.max(1, Math.ceil(count / most)); // a fine mesh is drawn with holes rather than slowly
  const triangles = [];
  for (let i = 0; i < count; i += step) {
    const at = 84 + 50 * i + 12;
    triangles.push([0, 12, 24].map((corner) => [0, 4, 8].map((part) => view.getFloat32(at + corner + part, true))));
  }
  return triangles;
}
