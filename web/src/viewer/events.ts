/** Handlers of events by name. */
export class Events<Map extends object> {
  private readonly handlers = new Map<keyof Map, Set<(event: never) => void>>();

  /** Adds a handler; returns what takes it away again. */
  on<Name extends keyof Map>(name: Name, handler: (event: Map[Name]) => void): () => void {
    const handlers = this.handlers.get(name) ?? new Set();
    this.handlers.set(name, handlers.add(handler));
    return () => void handlers.delete(handler);
  }

  emit<Name extends keyof Map>(name: Name, event: Map[Name]): void {
    for (const handler of [...(this.handlers.get(name) ?? [])]) {
      (handler as (event: Map[Name]) => void)(event);
    }
  }

  /** Whether anyone listens. */
  has(name: keyof Map): boolean {
    return (this.handlers.get(name)?.size ?? 0) > 0;
  }
}
