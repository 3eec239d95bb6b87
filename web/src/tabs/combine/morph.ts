export * from "../shared/morph.ts";
