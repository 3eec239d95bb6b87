/** Turning with a ring: the thing follows the pointer around the ring. */
import { Quaternion, Vector3, type Object3D, type PerspectiveCamera } from "three";

const AXES = "XYZ";

/** Cosine of the angle between a ring's axis and the view, below which it is seen from its side. */
export const EDGE_ON = 0.2;

export class Turning {
  private readonly pointer = new Vector3();
  private readonly start = new Quaternion();
  private angle = 0;
  private turned = 0;
  private readonly ended = new AbortController();

  /**
   * @param element whose pointer it is; heard before all who listen later
   */
  constructor(
    private readonly camera: PerspectiveCamera,
    element: HTMLElement,
  ) {
    const follow = (event: PointerEvent) => {
      const { left, top, width, height } = element.getBoundingClientRect();
      const x = (2 * (event.clientX - left)) / width - 1;
      this.pointer.set(x, 1 - (2 * (event.clientY - top)) / height, 0.5);
    };
    const { signal } = this.ended;
    element.addEventListener("pointerdown", follow, { signal });
    element.addEventListener("pointermove", follow, { signal });
  }

  /** The pointer took the ring about an axis, X, Y or Z of space. */
  begin(handle: Object3D, axis: string): void {
    this.start.copy(handle.quaternion);
    this.turned = 0;
    this.angle = this.around(handle, axis) ?? 0;
  }

  /** The pointer moved. */
  turn(handle: Object3D, axis: string): void {
    const angle = this.around(handle, axis);
    if (angle === null) return;
    const step = angle - this.angle;
    this.turned += step - 2 * Math.PI * Math.round(step / (2 * Math.PI));
    this.angle = angle;
    handle.quaternion.setFromAxisAngle(unit(axis), this.turned).multiply(this.start);
  }

  /** The pointer's angle about an axis, null where it does not meet the ring's plane. */
  private around(handle: Object3D, axis: string): number | null {
    const direction = this.pointer.clone().unproject(this.camera).sub(this.camera.position);
    const normal = unit(axis);
    const away = handle.position.clone().sub(this.camera.position).dot(normal);
    const share = away / direction.dot(normal);
    if (!(share > 0)) return null;
    const met = direction.multiplyScalar(share).add(this.camera.position).sub(handle.position);
    const k = AXES.indexOf(axis);
    return Math.atan2(met.getComponent((k + 2) % 3), met.getComponent((k + 1) % 3));
  }

  dispose(): void {
    this.ended.abort();
  }
}

function unit(axis: string): Vector3 {
  return new Vector3().setComponent(AXES.indexOf(axis), 1);
}
