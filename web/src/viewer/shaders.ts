/** How surfaces and their edges are drawn. */

/** What a surface's colour follows, as the shaders' PAINT. */
export const PAINT = { plain: 0, values: 1, vertices: 2, faces: 3 };

const COLOUR = /* glsl */ `
vec3 linear(vec3 c) {
  return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
}
vec3 encoded(vec3 c) {
  return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}
`;

export const SURFACE_VERTEX = /* glsl */ `
in vec4 tint;
out vec3 vNormal;
out vec3 vView;
out vec4 vTint;
#if PAINT == 1
in float value;
out float vValue;
#elif PAINT == 2
in vec4 paint;
out vec3 vPaint;
#elif PAINT == 3
in vec4 paint;
flat out vec3 vPaint;
#endif
void main() {
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  vView = view.xyz;
  vNormal = normalMatrix * normal;
  vTint = tint;
#if PAINT == 1
  vValue = value;
#elif PAINT >= 2
  vPaint = paint.rgb;
#endif
  gl_Position = projectionMatrix * view;
}
`;

export const SURFACE_FRAGMENT = /* glsl */ `
precision highp float;
uniform vec3 colour;
uniform float opacity;
uniform float flatness;
uniform vec3 key;
uniform vec3 upward;
uniform vec3 sky;
uniform vec3 ground;
uniform vec3 sun;
uniform vec3 inside;
in vec3 vNormal;
in vec3 vView;
in vec4 vTint;
#if PAINT == 1
uniform sampler2D map;
in float vValue;
#elif PAINT == 2
in vec3 vPaint;
#elif PAINT == 3
flat in vec3 vPaint;
#endif
out vec4 drawn;
${COLOUR}
vec3 painted() {
#if PAINT == 0
  return linear(colour);
#elif PAINT == 1
  if (vValue < -0.5) return linear(colour);
  float size = float(textureSize(map, 0).x);
  float at = (0.5 + clamp(vValue, 0.0, 1.0) * (size - 1.0)) / size;
  return linear(texture(map, vec2(at, 0.5)).rgb);
#else
  return linear(vPaint);
#endif
}
void main() {
  vec3 eye = normalize(-vView);
  vec3 n = flatness > 0.5 ? cross(dFdx(vView), dFdy(vView)) : vNormal;
  n *= inversesqrt(max(dot(n, n), 1e-36));
  // a sliver may be rounded over: what its neighbours say counts
  bool behind = !gl_FrontFacing && (flatness > 0.5 || dot(n, eye) < 0.25);
  if (behind && flatness < 0.5) n = -n;
  vec3 base = painted();
  base = mix(base, linear(vTint.rgb / max(vTint.a, 1e-3)), 0.72 * vTint.a);
#if PAINT == 0
  if (behind) base *= inside;
  float gloss = 1.0;
#else
  if (behind) base *= 0.8;
  float gloss = 0.5;
#endif
  float facing = max(dot(n, eye), 0.0);
  vec3 light = mix(ground, sky, 0.5 + 0.5 * dot(n, upward));
  light += sun * max((dot(n, key) + 0.2) / 1.2, 0.0);
#if PAINT != 0
  light *= 0.86;
#endif
  float shine = pow(max(dot(n, normalize(key + eye)), 0.0), 32.0) * 0.09;
  float rim = pow(1.0 - facing, 3.0) * (0.35 + 0.65 * max(dot(n, upward), 0.0)) * 0.12;
  drawn = vec4(encoded(clamp(base * light + gloss * (shine + rim), 0.0, 1.0)), opacity);
}
`;

/**
 * Lines fade to a share (crowding.x) where faces have fewer pixels than crowding.y, which the
 * normal's length tells.
 */
export const LINE_VERTEX = /* glsl */ `
uniform float pixels;
uniform float opacity;
uniform vec2 crowding;
uniform vec2 shift;
out float vOpacity;
void main() {
  vec4 view = modelViewMatrix * vec4(position, 1.0);
  vec3 n = normalMatrix * normal;
  float area = length(normal);
  float facing = abs(dot(n, view.xyz)) / max(length(n) * length(view.xyz), 1e-30);
  float side = sqrt(0.19 * area) * pixels / max(-view.z, 1e-6) * mix(0.35, 1.0, facing);
  vOpacity = opacity * mix(crowding.x, 1.0, smoothstep(0.1 * crowding.y, crowding.y, side));
  gl_Position = projectionMatrix * view;
  gl_Position.xy += shift * gl_Position.w;
}
`;

export const LINE_FRAGMENT = /* glsl */ `
precision highp float;
uniform vec3 colour;
in float vOpacity;
out vec4 drawn;
void main() {
  if (vOpacity < 0.004) discard;
  drawn = vec4(colour, vOpacity);
}
`;
