import type { TabName } from "../state.ts";

/** What a method does, in a few lines. */
export function Picture({ tab }: { tab: TabName }) {
  return (
    <svg class="picture" viewBox="0 0 120 64" aria-hidden="true">
      {pictures[tab]}
    </svg>
  );
}

const pictures = {
  combine: (
    <>
      <rect class="fill" x="12" y="14" width="36" height="36" rx="3" />
      <circle class="fill" cx="90" cy="32" r="20" />
      <path class="fine" d="M12 26h36M12 38h36M24 14v36M36 14v36" />
      <path
        class="fine"
        d="M71 26c12 4 26 4 38 0M71 38c12-4 26-4 38 0M84 13c-4 12-4 26 0 38M96 13c4 12 4 26 0 38"
      />
      <path class="strong" d="M54 32h9M60 28.5l3.5 3.5-3.5 3.5" />
    </>
  ),
  register: (
    <>
      <path class="fill" d="M18 50c-6-16-2-36 14-38s22 14 18 24-6 10-8 16z" />
      <path class="fill" d="M72 52c-10-10-8-36 12-40s26 16 20 28-10 10-12 14z" />
      <path class="fine" d="M26 24C48 14 66 14 82 22M44 40c14 8 32 8 46 2" />
      <g class="dots">
        <circle cx="26" cy="24" r="2.6" />
        <circle cx="44" cy="40" r="2.6" />
        <circle cx="82" cy="22" r="2.6" />
        <circle cx="90" cy="42" r="2.6" />
      </g>
    </>
  ),
  deform: (
    <>
      <path class="fill" d="M14 46c14-2 22-30 46-30s32 28 46 30c-28 6-64 6-92 0z" />
      <path
        class="fine"
        d="M24 43c22 3 50 3 72 0M34 34c16 3 36 3 52 0M44 24c10 2 22 2 32 0M60 16v32M44 24c-6 8-8 16-8 23M76 24c6 8 8 16 8 23"
      />
      <path class="strong" d="M60 16V5M56.5 8.5 60 5l3.5 3.5" />
      <g class="dots">
        <circle cx="60" cy="16" r="3" />
      </g>
    </>
  ),
  quad: (
    <>
      <path class="fill" d="M16 34c8-26 80-26 88 0-8 24-80 24-88 0z" />
      <path
        class="fine"
        d="M22 24c20 8 56 8 76 0M16 34c24 8 64 8 88 0M22 44c20 6 56 6 76 0M34 18c-6 10-6 22 0 33M52 15c-4 12-4 26 0 38M70 15c4 12 4 26 0 38M88 18c6 10 6 22 0 33"
      />
      <path class="strong" d="M52 15c-4 12-4 26 0 38M16 34c24 8 64 8 88 0" />
      <g class="dots">
        <circle cx="49" cy="39.5" r="2.6" />
      </g>
    </>
  ),
  design: (
    <>
      <path class="fine" d="M20 50 32 12l52 4 18 34z" />
      <path class="fill" d="M34 44c2-20 12-26 26-25 14 0 24 8 28 25-16 5-38 5-54 0z" />
      <path class="strong" d="M38 36c14-10 30 6 44-4" />
      <g class="dots">
        <circle cx="20" cy="50" r="2.4" />
        <circle cx="32" cy="12" r="2.4" />
        <circle cx="84" cy="16" r="2.4" />
        <circle cx="102" cy="50" r="2.4" />
      </g>
    </>
  ),
} as const;
