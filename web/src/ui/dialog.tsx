import type { ComponentChildren } from "preact";
import { useEffect, useId, useRef } from "preact/hooks";
import { Button, IconButton } from "./buttons.tsx";

type DialogProps = {
  title: string;
  onClose(): void;
  /** Buttons at its foot, the last one the one most wanted. */
  actions?: ComponentChildren;
  wide?: boolean;
  children: ComponentChildren;
};

/** A window above the page that takes the keyboard until it is closed; it is open while it is drawn. */
export function Dialog({ title, onClose, actions, wide, children }: DialogProps) {
  const ref = useRef<HTMLDialogElement>(null);
  const id = useId();
  useEffect(() => {
    const dialog = ref.current!;
    dialog.showModal();
    return () => dialog.close();
  }, []);
  return (
    <dialog
      ref={ref}
      class={wide ? "wide" : undefined}
      aria-labelledby={id}
      onCancel={(event) => {
        event.preventDefault();
        onClose();
      }}
      onKeyDown={(event) => event.stopPropagation()}
      onPointerDown={(event) => event.target === ref.current && onClose()}
    >
      <div class="dialog-frame" tabIndex={-1} autofocus>
        <header>
          <h2 id={id}>{title}</h2>
          <IconButton icon="close" label="Close" onClick={onClose} />
        </header>
        <div class="dialog-body">{children}</div>
        {actions && <footer>{actions}</footer>}
      </div>
    </dialog>
  );
}

type ConfirmProps = {
  title: string;
  text: string;
  /** What the button that goes on says. */
  yes: string;
  onYes(): void;
  onClose(): void;
};

/** Asks before something that cannot be undone. */
export function Confirm({ title, text, yes, onYes, onClose }: ConfirmProps) {
  return (
    <Dialog
      title={title}
      onClose={onClose}
      actions={
        <>
          <Button label="Keep" onClick={onClose} />
          <Button
            label={yes}
            kind="danger"
            onClick={() => {
              onClose();
              onYes();
            }}
          />
        </>
      }
    >
      <p>{text}</p>
    </Dialog>
  );
}
