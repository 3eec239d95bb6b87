import type { MeshEntry } from "../state.ts";
import { useId } from "preact/hooks";
import { type Answer, useHeld } from "./held.ts";
import { count } from "./numbers.ts";

export type Option<V extends string> = {
  value: V;
  label: string;
  hint?: string;
  disabled?: boolean;
};

type ChoiceProps<V extends string> = {
  label: string;
  value: V;
  options: readonly Option<V>[];
  onChange(value: V): Answer;
  /** Side by side, or in a list that opens; by default as it fits. */
  as?: "segments" | "select";
  disabled?: boolean;
  hint?: string;
};

const mostSegments = 4;
const longestSegments = 26; // characters
const mostBeside = 180; // pixels of segments that stand beside their label, not below it

/** One of a few. */
export function Choice<V extends string>(props: ChoiceProps<V>) {
  const { options, as } = props;
  const long = options.reduce((sum, option) => sum + option.label.length, 0);
  const fits = options.length <= mostSegments && long <= longestSegments;
  return (as ?? (fits ? "segments" : "select")) === "segments" ? Segments(props) : Select(props);
}

function Segments<V extends string>(props: ChoiceProps<V>) {
  const { label, value, options, onChange, disabled, hint } = props;
  const held = useHeld(value);
  const name = useId();
  const width = options.reduce((sum, option) => sum + 16 + 7 * option.label.length, 0);
  return (
    <div class={`field${width > mostBeside ? " stacked" : ""}`} title={hint}>
      <span class="label" id={`${name}-label`}>
        {label}
      </span>
      <span class="segments" role="radiogroup" aria-labelledby={`${name}-label`}>
        {options.map((option) => (
          <label key={option.value} title={option.hint}>
            <input
              type="radio"
              name={name}
              value={option.value}
              checked={held.shown === option.value}
              disabled={disabled || option.disabled}
              onChange={() => {
                held.hold(option.value);
                held.settle(onChange(option.value));
              }}
            />
            <span>{option.label}</span>
          </label>
        ))}
      </span>
    </div>
  );
}

function Select<V extends string>(props: ChoiceProps<V>) {
  const { label, value, options, onChange, disabled, hint } = props;
  const held = useHeld(value);
  const id = useId();
  return (
    <div class="field" title={hint}>
      <label for={id}>{label}</label>
      <select
        id={id}
        value={held.shown}
        disabled={disabled}
        onChange={(event) => {
          const next = event.currentTarget.value as V;
          held.hold(next);
          held.settle(onChange(next));
        }}
      >
        {options.map((option) => (
          <option key={option.value} value={option.value} disabled={option.disabled}>
            {option.label}
          </option>
        ))}
      </select>
    </div>
  );
}

type MeshChoiceProps = {
  label: string;
  meshes: readonly MeshEntry[];
  value: string | null;
  onChange(mesh: string | null): Answer;
  /** What "no mesh" is called. */
  none?: string;
  disabled?: boolean;
  hint?: string;
};

/** One of the open meshes, or none. */
export function MeshChoice({ meshes, value, onChange, none = "none", ...rest }: MeshChoiceProps) {
  const options = meshes.map((mesh) => ({
    value: mesh.id,
    label: `${mesh.name} (${count(mesh.vertices)})`,
  }));
  return (
    <Choice
      {...rest}
      as="select"
      value={value ?? ""}
      options={[{ value: "", label: `– ${none} –` }, ...options]}
      onChange={(mesh) => onChange(mesh || null)}
    />
  );
}

type ToggleProps = {
  label: string;
  value: boolean;
  onChange(value: boolean): Answer;
  disabled?: boolean;
  hint?: string;
};

/** On or off. */
export function Toggle({ label, value, onChange, disabled, hint }: ToggleProps) {
  const held = useHeld(value);
  return (
    <label class="field toggle" title={hint}>
      <span class="label">{label}</span>
      <input
        type="checkbox"
        role="switch"
        checked={held.shown}
        disabled={disabled}
        onChange={(event) => {
          const next = event.currentTarget.checked;
          held.hold(next);
          held.settle(onChange(next));
        }}
      />
    </label>
  );
}
