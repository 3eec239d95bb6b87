/** The tabs, in the order of the bar. */

import type { TabName } from "../state.ts";
import { combine } from "./combine.tsx";
import { deform } from "./deform.tsx";
import { design } from "./design.tsx";
import { quad } from "./quad.tsx";
import { stub } from "./stub.tsx";
import type { AnyTab } from "./tab.ts";

export const tabs: readonly AnyTab[] = [
  combine,
  stub("register", "Register", "One mesh takes on the form of another.", 2),
  deform,
  quad,
  design,
];

export const tabNamed = (name: TabName) => tabs.find((tab) => tab.name === name);
