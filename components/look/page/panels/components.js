// SPDX-License-Identifier: Apache-2.0
import {Rows, button, element, labelled, setText, table} from '../dom.js';
import {Panel} from '../panel.js';

const NEXT = {unconfigured: ['configure'], inactive: ['activate', 'cleanup'], active: ['deactivate']};
const TRANSITIONS = ['configure', 'activate', 'deactivate', 'cleanup'];

/** The components with their states: lifecycle transitions, loading and unloading. */
export class ComponentsPanel extends Panel {
  constructor(robot) {
    super(robot, 'components', 'Components');
    const {table: list, body} = table('Components of the container', ['Component', 'State', 'Change']);
    this.rows = new Rows(
      body,
      () => this.makeRow(),
      (row, component) => this.fillRow(row, component),
    );
    this.body.append(list, this.loader());
    this.count = 0;
  }

  start() {
    this.poll('get_components', {}, 1000, ({components}) => {
      this.count = components.length;
      this.rows.show(components, ({id}) => id);
    });
    this.on(this.robot, 'right', () => this.rows.rows.forEach((row) => this.fillRow(row, row.component)));
  }

  makeRow() {
    const row = element('tr');
    row.nameCell = element('td');
    row.node = row.nameCell.appendChild(element('strong'));
    row.plugin = row.nameCell.appendChild(element('small'));
    row.state = element('td').appendChild(element('span', {class: 'badge'}));
    row.buttons = Object.fromEntries(
      TRANSITIONS.map((transition) => [
        transition,
        button(transition, () =>
          this.robot.order(`${transition} ${row.component.node}`, 'change_state', {component: row.component.node, transition}),
        ),
      ]),
    );
    row.unload = button('unload', () => {
      if (window.confirm(`Unload ${row.component.node}?`))
        this.robot.order(`Unload ${row.component.node}`, 'unload_component', {component: row.component.node});
    });
    row.append(row.nameCell, row.state.parentNode, element('td', {class: 'buttons'}, ...Object.values(row.buttons), row.unload));
    return row;
  }

  fillRow(row, component) {
    row.component = component;
    setText(row.node, component.node);
    setText(row.plugin, component.plugin);
    const label = component.managed ? component.state.label : 'no lifecycle';
    const fault = component.fault[0] ?? component.open_faults[0];
    setText(row.state, fault ? `${label}: ${fault.code}` : label);
    row.state.title = fault ? fault.text : '';
    row.state.className = `badge ${fault ? 'bad' : label === 'active' ? 'good' : 'dull'}`;
    for (const [transition, one] of Object.entries(row.buttons)) {
      one.hidden = !component.managed || !(NEXT[label] ?? []).includes(transition);
      one.disabled = !this.robot.mayOperate;
      one.title = this.robot.whyNot;
    }
    row.unload.disabled = !this.robot.mayOperate;
    row.unload.title = this.robot.whyNot;
  }

  loader() {
    const what = element('input', {
      required: true,
      placeholder: 'pkg::Class, or a name of the launch file',
      autocomplete: 'off',
      spellcheck: 'false',
    });
    const name = element('input', {placeholder: 'its own', autocomplete: 'off', spellcheck: 'false'});
    const load = element('button', {type: 'submit'}, 'load');
    const form = element('form', {class: 'row'}, labelled('component', what), labelled('node name', name), load);
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.robot.order(`Load ${what.value}`, 'load_component', {component: what.value.trim(), node_name: name.value.trim()});
    });
    this.guard(load);
    return form;
  }

  report() {
    return {...super.report(), components: this.count};
  }
}
