import { Button, Buttons, Choice, Hint, NumberField, Section, Slider } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { mediators, type Props } from "./types.ts";

const called: Record<(typeof mediators)[number], string> = {
  sphere: "Sphere",
  quadruped: "Animal on four legs",
  humanoid: "Man",
};

/** How the model is made. */
export function Options(props: Props) {
  const { state, studio } = props;
  const { recipe } = state;
  const change = (options: object) => studio.do("register", "change", { options });
  return (
    <>
      <Section title="Options">
        <Mediator {...props} />
        <Slider
          label="Keep form"
          hint="What the form of faces weighs against covering the target: 0.001 for a close fit, 0.03 for statistics, where vertices should not slide"
          min={1e-5}
          max={1}
          logarithmic
          value={recipe.distortion}
          onChange={(distortion) => change({ distortion })}
        />
      </Section>
      <Section title="More" open={false}>
        <NumberField
          label="Seed"
          hint="For what is left to chance; the same seed gives the same model"
          min={0}
          step={1}
          digits={16}
          value={recipe.seed}
          onChange={(seed) => change({ seed: Math.round(seed) })}
        />
        <Choice
          label="Rule"
          value={recipe.rule}
          options={[
            {
              value: "nearest",
              label: "Nearest",
              hint: "A point attracts the vertex nearest to it",
            },
            { value: "literal", label: "Literal", hint: "As published, for study: it folds" },
          ]}
          onChange={(rule) => change({ rule })}
        />
        <Regions {...props} />
        <Further settings={recipe.settings} studio={studio} />
      </Section>
    </>
  );
}

function Mediator({ state, studio }: Props) {
  const meshes = studio.state?.meshes ?? [];
  return (
    <Choice
      label="Mediator"
      as="select"
      hint="The shape on which both meet. With landmarks on all limbs the sphere is enough; without, a shape with the same parts says which limb is which. Both must look to +z then, +y up"
      value={state.mediator ?? state.recipe.mediator}
      options={[
        ...mediators.map((name) => ({ value: name as string, label: called[name] })),
        ...meshes.map(({ id, name }) => ({ value: id, label: `mesh: ${name}` })),
      ]}
      onChange={(value) =>
        studio.do(
          "register",
          "set_mediator",
          meshes.some((mesh) => mesh.id === value) ? { mesh: value } : { name: value },
        )
      }
    />
  );
}

/** Attributes whose equal labels belong together. */
function Regions({ state, view, studio }: Props) {
  const [own, others] = view.labels ?? [[], []];
  const { regions } = state.recipe;
  if (!regions && (own.length === 0 || others.length === 0)) return null;
  const pairs = own.flatMap((a) => others.map((b) => [a, b] as const));
  const value = regions ? JSON.stringify(regions) : "";
  const known = pairs.some((pair) => JSON.stringify(pair) === value);
  return (
    <Choice
      label="Regions"
      as="select"
      hint="Labels of the vertices: what has a label goes to where the target has the same"
      value={value}
      options={[
        { value: "", label: "none" },
        ...(regions && !known ? [{ value, label: regions.join(" – ") }] : []),
        ...pairs.map((pair) => ({ value: JSON.stringify(pair), label: pair.join(" – ") })),
      ]}
      onChange={(chosen) =>
        studio.do("register", "change", {
          options: { regions: chosen === "" ? null : JSON.parse(chosen) },
        })
      }
    />
  );
}

/** What a recipe says beside the controls. */
function Further({ settings, studio }: { settings: Record<string, unknown>; studio: Studio }) {
  const said = Object.entries(settings).map(([name, value]) => `${name} ${value}`);
  if (said.length === 0) return null;
  return (
    <>
      <Hint>The recipe sets {said.join(", ")}.</Hint>
      <Buttons>
        <Button
          label="Take defaults"
          kind="quiet"
          onClick={() => void studio.do("register", "change", { options: { settings: null } })}
        />
      </Buttons>
    </>
  );
}
