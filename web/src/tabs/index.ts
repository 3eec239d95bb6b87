/** The tabs, in the order of the bar. */

import type { TabName } from "../state.ts";
import { combine } from "./combine.tsx";
import { deform } from "./deform.tsx";
import { design } from "./design.tsx";
import { quad } from "./quad.tsx";
import { register } from "./register.tsx";
import type { AnyTab } from "./tab.ts";

export const tabs: readonly AnyTab[] = [combine, register, deform, quad, design];

export const tabNamed = (name: TabName) => tabs.find((tab) => tab.name === name);
