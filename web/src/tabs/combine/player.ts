export * from "../shared/player.ts";
