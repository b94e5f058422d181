// SPDX-License-Identifier: Apache-2.0

const NARROW = '(max-width: 760px)';
const FIRST_WIDE = ['world', 'camera', 'drive', 'components', 'plots', 'streams'];
const FIRST_NARROW = ['world', 'drive'];

/** Which panels are shown: a button for each. On a narrow screen a panel replaces the one before it, and the joystick stays below it until it is
 * pressed away. */
export class Tabs {
  constructor(panels, root, makeButton) {
    this.panels = new Map(panels.map((panel) => [panel.name, panel]));
    this.narrow = window.matchMedia(NARROW);
    this.buttons = new Map(panels.map(({name, title}) => [name, makeButton(title, () => this.press(name))]));
    root.append(...this.buttons.values());
    this.narrow.addEventListener('change', () => {
      this.load();
      this.apply();
    });
    this.load();
  }

  get key() {
    return this.narrow.matches ? 'panels, narrow' : 'panels, wide';
  }

  load() {
    const kept = sessionStorage.getItem(this.key);
    this.shown = new Set(kept ? kept.split(' ').filter((name) => this.panels.has(name)) : this.narrow.matches ? FIRST_NARROW : FIRST_WIDE);
  }

  press(name) {
    if (this.shown.has(name) && (!this.narrow.matches || name === 'drive')) this.shown.delete(name);
    else {
      if (this.narrow.matches && name !== 'drive') for (const other of this.shown) if (other !== 'drive') this.shown.delete(other);
      this.shown.add(name);
    }
    this.save();
    this.buttons.get(name).scrollIntoView({block: 'nearest', inline: 'nearest'});
  }

  /** Shows these and no other. */
  choose(names) {
    this.shown = new Set(names);
    this.save();
  }

  save() {
    sessionStorage.setItem(this.key, [...this.shown].join(' '));
    this.apply();
  }

  apply() {
    const isVisible = document.visibilityState === 'visible';
    for (const [name, panel] of this.panels) {
      const isShown = this.shown.has(name);
      this.buttons.get(name).setAttribute('aria-pressed', String(isShown));
      if (isShown && isVisible) panel.show();
      else panel.hide();
    }
  }
}
