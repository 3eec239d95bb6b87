/** Choices of looks that outlive the page, on this computer. */
export function kept<T>(name: string, otherwise: T): T {
  try {
    const text = localStorage.getItem(`henkei ${name}`);
    return text === null ? otherwise : (JSON.parse(text) as T);
  } catch {
    return otherwise;
  }
}

export function keep(name: string, value: unknown): void {
  try {
    localStorage.setItem(`henkei ${name}`, JSON.stringify(value));
  } catch {
    // storage can be forbidden or full; then the choice ends with the page
  }
}
