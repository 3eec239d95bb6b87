import { useId, useRef, useState } from "preact/hooks";
import { type Answer, useHeld } from "./held.ts";
import { clamped, parsed, short, stepped } from "./numbers.ts";

export type Range = { min?: number; max?: number; step?: number };

type BareProps = Range & {
  label: string;
  value: number;
  onInput?(value: number): void;
  onCancel?(): void;
  onChange(value: number): Answer;
  disabled?: boolean;
  digits?: number;
  id?: string;
};

/**
 * A field for a number, without its label on show.
 *
 * What is typed is told by `onInput` while it is a number within bounds, and by `onChange` on Enter
 * or when the field is left; Escape takes it back, which `onCancel` is told if something was told by
 * `onInput`, or else `onInput` itself. Arrow keys step, with Shift by ten steps.
 */
export function BareNumber(props: BareProps) {
  const { label, value, min, max, step, onInput, onCancel, onChange } = props;
  const { disabled, digits = 6, id } = props;
  const held = useHeld(value);
  const [text, setText] = useState<string | null>(null);
  const typed = text === null ? null : parsed(text);
  const usable = typed !== null && clamped(typed, min, max) === typed;

  const begun = useRef(false);
  function input(next: string) {
    setText(next);
    const number = parsed(next);
    if (number === null || clamped(number, min, max) !== number) return;
    begun.current = true;
    onInput?.(number);
  }
  function commit() {
    if (text === null) return;
    const final = typed === null ? value : clamped(typed, min, max);
    setText(null);
    if (final === value && !begun.current) return;
    begun.current = false;
    held.hold(final);
    held.settle(onChange(final));
  }
  function nudge(by: number) {
    const from = typed ?? held.shown;
    input(short(clamped(stepped(from + by * (step ?? guess(from)), step), min, max), 12));
  }
  return (
    <input
      class={`number${text !== null && !usable ? " bad" : ""}`}
      id={id}
      type="text"
      inputMode="decimal"
      role="spinbutton"
      autocomplete="off"
      spellcheck={false}
      aria-label={label}
      aria-valuenow={typed ?? held.shown}
      aria-valuemin={min}
      aria-valuemax={max}
      aria-invalid={text !== null && !usable}
      disabled={disabled}
      value={text ?? short(held.shown, digits)}
      onFocus={(event) => event.currentTarget.select()}
      onInput={(event) => input(event.currentTarget.value)}
      onBlur={commit}
      onKeyDown={(event) => {
        const by = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
        if (by) {
          event.preventDefault();
          nudge(event.shiftKey ? 10 * by : by);
        } else if (event.key === "Enter") {
          event.currentTarget.blur();
        } else if (event.key === "Escape") {
          event.stopPropagation();
          setText(null);
          if (begun.current && onCancel) onCancel();
          else if (begun.current) onInput?.(value);
          begun.current = false;
          const field = event.currentTarget;
          requestAnimationFrame(() => field.blur());
        }
      }}
    />
  );
}

/** A sensible step for a number without one: its second digit. */
function guess(value: number): number {
  return value === 0 ? 0.1 : 10 ** (Math.floor(Math.log10(Math.abs(value))) - 1);
}

type NumberFieldProps = BareProps & { unit?: string; hint?: string };

/** A number with its label. */
export function NumberField({ unit, hint, ...field }: NumberFieldProps) {
  const id = useId();
  return (
    <div class="field" title={hint}>
      <label for={id}>{field.label}</label>
      <span class="number-with-unit">
        <BareNumber id={id} {...field} />
        {unit && <span class="unit">{unit}</span>}
      </span>
    </div>
  );
}

type SliderProps = NumberFieldProps & {
  min: number;
  max: number;
  /** Equal ways along the slider are equal factors; min is above 0. */
  logarithmic?: boolean;
};

const ticks = 1000; // of a slider without steps

/** A slider and a field for the same number. `onInput` is told all the way, `onChange` at the end. */
export function Slider(props: SliderProps) {
  const { label, value, min, max, step, logarithmic, onInput, onCancel, onChange } = props;
  const { disabled, hint } = props;
  const held = useHeld(value);
  const id = useId();
  const fine = step === undefined || logarithmic;
  const place = (v: number) =>
    logarithmic ? Math.log(v / min) / Math.log(max / min) : (v - min) / (max - min || 1);
  const at = (t: number) => {
    const v = logarithmic ? min * (max / min) ** t : min + t * (max - min);
    return clamped(step ? stepped(v, step) : Number(v.toPrecision(4)), min, max);
  };
  const read = (input: HTMLInputElement) =>
    fine ? at(Number(input.value) / ticks) : clamped(stepped(Number(input.value), step), min, max);
  const t = clamped(place(clamped(held.shown, min, max)), 0, 1);
  return (
    <div class="field slider" title={hint}>
      <label for={id}>{label}</label>
      <input
        id={id}
        type="range"
        min={fine ? 0 : min}
        max={fine ? ticks : max}
        step={fine ? 1 : step}
        value={fine ? Math.round(t * ticks) : clamped(held.shown, min, max)}
        aria-valuetext={short(held.shown)}
        style={{ "--filled": `${100 * t}%` }}
        disabled={disabled}
        onInput={(event) => {
          const next = read(event.currentTarget);
          held.hold(next);
          onInput?.(next);
        }}
        onChange={(event) => {
          const next = read(event.currentTarget);
          held.hold(next);
          held.settle(onChange(next));
        }}
      />
      <span class="number-with-unit">
        <BareNumber
          label={`${label} value`}
          value={held.shown}
          min={min}
          max={max}
          step={step}
          digits={props.digits}
          disabled={disabled}
          onInput={onInput}
          onCancel={onCancel}
          onChange={onChange}
        />
        {props.unit && <span class="unit">{props.unit}</span>}
      </span>
    </div>
  );
}

export type Vector = [number, number, number];

type VectorFieldProps = Range & {
  label: string;
  unit?: string;
  value: Vector;
  onInput?(value: Vector): void;
  onCancel?(): void;
  onChange(value: Vector): Answer;
  disabled?: boolean;
  hint?: string;
  digits?: number;
  axes?: [string, string, string];
};

const dust = 1e-12; // of the largest of three numbers, below which another is rounding

/** Three numbers, of x, y and z. */
export function VectorField(props: VectorFieldProps) {
  const { label, unit, onInput, onChange, hint, axes = ["x", "y", "z"], ...field } = props;
  const held = useHeld(props.value); // the next number may come before this one is answered
  const value = held.shown;
  const largest = Math.max(...value.map(Math.abs));
  const changed = (axis: number, number: number): Vector => {
    const next: Vector = [...value];
    next[axis] = number;
    return next;
  };
  const set = (next: Vector): Answer => {
    held.hold(next);
    const answer = onChange(next);
    held.settle(answer);
    return answer;
  };
  return (
    <div class="field vector" role="group" aria-label={label} title={hint}>
      <span class="label">{unit ? `${label}, ${unit}` : label}</span>
      {axes.map((axis, k) => (
        <span class="axis" key={axis} data-axis={k}>
          <span aria-hidden="true">{axis}</span>
          <BareNumber
            digits={5}
            {...field}
            label={`${label} ${axis}`}
            value={Math.abs(value[k]!) < dust * largest ? 0 : value[k]!}
            onInput={onInput && ((number) => onInput(changed(k, number)))}
            onChange={(number) => set(changed(k, number))}
          />
        </span>
      ))}
    </div>
  );
}

type TextFieldProps = {
  label: string;
  value: string;
  onChange(value: string): Answer;
  placeholder?: string;
  disabled?: boolean;
  hint?: string;
};

/** A line of text. */
export function TextField({ label, value, onChange, placeholder, disabled, hint }: TextFieldProps) {
  const id = useId();
  const [text, setText] = useState<string | null>(null);
  const commit = () => {
    if (text !== null && text !== value) void onChange(text);
    setText(null);
  };
  return (
    <div class="field" title={hint}>
      <label for={id}>{label}</label>
      <input
        id={id}
        type="text"
        class="text"
        autocomplete="off"
        spellcheck={false}
        placeholder={placeholder}
        disabled={disabled}
        value={text ?? value}
        onInput={(event) => setText(event.currentTarget.value)}
        onBlur={commit}
        onKeyDown={(event) => event.key === "Enter" && event.currentTarget.blur()}
      />
    </div>
  );
}
