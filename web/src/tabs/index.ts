/** The tabs, in the order of the bar. */

import type { TabName } from "../state.ts";
import { stub } from "./stub.tsx";
import type { AnyTab } from "./tab.ts";

export const tabs: readonly AnyTab[] = [
  stub("combine", "Combine", "Two surfaces become one mesh with two forms: morph between them.", 2),
  stub("register", "Register", "One mesh takes on the form of another.", 2),
  stub("deform", "Deform", "Drag parts of a surface; its details and features follow.", 1),
  stub("quad", "Quad", "A surface in quads that follow its shape.", 1),
  stub("design", "Design", "A smooth surface through points and curves.", 1),
];

export const tabNamed = (name: TabName) => tabs.find((tab) => tab.name === name);
