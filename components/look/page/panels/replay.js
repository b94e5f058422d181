// SPDX-License-Identifier: Apache-2.0
import {button, element, labelled, select, setText} from '../dom.js';
import {Panel} from '../panel.js';
import {PLAYERS_OWN, findEdge, nanosecondsOf, rulesApart, timeOf} from '../replay.js';
import {parametersOf} from '../values.js';

const PLUGIN = 'nacelle::record::PlayComponent';
const CLOCK_HZ = 10;
const GLIMPSE_MS = 250; // two scans
const PREFIX = '/replay';

/** Opens a recording in the container, plays and scrubs it. */
export class ReplayPanel extends Panel {
  constructor(robot) {
    super(robot, 'replay', 'Replay');
    this.path = element('input', {required: true, placeholder: 'file or folder on the robot', autocomplete: 'off', spellcheck: 'false'});
    this.topics = element('input', {placeholder: 'all', autocomplete: 'off', spellcheck: 'false'});
    this.apart = element('input', {type: 'checkbox', checked: true});
    this.open = element('button', {type: 'submit'}, 'open');
    const form = element(
      'form',
      {class: 'row'},
      labelled('recording', this.path),
      labelled('topics', this.topics),
      labelled(`put topics that exist below ${PREFIX}`, this.apart, {class: 'check'}),
      this.open,
    );
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      this.load();
    });
    this.toggle = button('▶ play', () => this.pause(!this.isPaused));
    this.slider = element('input', {type: 'range', min: 0, max: 1, step: 0.05, value: 0, 'aria-label': 'Position in seconds'});
    this.slider.addEventListener('input', () => this.scrub());
    this.rate = select(
      [
        ['0.1', '0.1 x'],
        ['0.5', '0.5 x'],
        ['1', '1 x'],
        ['2', '2 x'],
        ['5', '5 x'],
        ['10', '10 x'],
      ],
      {'aria-label': 'Rate', onchange: () => this.robot.order('Rate', this.service('set_rate'), {rate: Number(this.rate.value)})},
    );
    this.rate.value = '1';
    this.close = button('close', () => this.robot.order('Close the recording', 'unload_component', {component: this.node}));
    this.where = element('output', {class: 'facts'});
    this.player = element('div', {class: 'player', hidden: true}, this.toggle, this.slider, this.where, labelled('rate', this.rate), this.close);
    this.body.append(form, this.player);
    this.guard(this.open, this.toggle, this.slider, this.rate, this.close);
    this.node = '';
    this.begin = null;
    this.isPaused = true;
  }

  start() {
    this.poll('get_components', {}, 1000, ({components}) => this.take(components.find(({plugin}) => plugin === PLUGIN)));
    this.subscribe(
      (channels) => channels.find(({topic, schemaName}) => schemaName === 'rosgraph_msgs/msg/Clock' && topic === `${this.node}/clock`),
      ({clock}) => this.noteTime(nanosecondsOf(clock)),
    );
    this.on(this.connection, 'services', () => {
      if (this.node) this.ask();
    });
  }

  service(name) {
    return `${this.node}/${name}`;
  }

  load() {
    const named = this.topics.value.split(/[\s,]+/).filter(Boolean);
    const parameters = {'storage.uri': this.path.value.trim(), 'play.clock_publish_frequency': CLOCK_HZ, 'play.loop': true};
    if (named.length > 0) parameters['play.topics'] = named;
    // The player's clock stays apart: the robot's own time goes on.
    const rules = ['/clock:=~/clock'];
    const known = [...this.connection.channels.values()].map(({topic}) => topic).filter((topic) => topic !== '/clock');
    if (this.apart.checked) {
      rules.push(...rulesApart([...known, ...named], PREFIX));
      parameters['play.exclude_topics'] = PLAYERS_OWN;
    }
    return this.robot.order('Open the recording', 'load_component', {component: PLUGIN, parameters: parametersOf(parameters), remap_rules: rules});
  }

  take(component) {
    const node = component ? component.node : '';
    this.player.hidden = node === '';
    if (node === this.node) return;
    this.node = node;
    this.begin = this.end = null;
    this.isPaused = false;
    this.say(node ? 'Looking for the beginning and the end ...' : '');
    this.connection.rejoin(); // the clock has the player's name
  }

  /** A time that is played leads to the beginning and the end. Without the right to operate, what was seen is all that is known. */
  noteTime(now) {
    this.now = now;
    if (this.begin === null) {
      this.begin = now;
      if (this.robot.mayOperate) this.measure();
    }
    if (this.begin > now) this.begin = now;
    if (!this.isMeasuring) this.showTime();
  }

  async measure() {
    const {node} = this;
    this.isMeasuring = true;
    const seek = async (ns) => (await this.connection.call(`${node}/seek`, {time: timeOf(ns)})).success;
    try {
      await this.connection.call(`${node}/pause`);
      const end = await findEdge(this.begin, 1n, seek);
      const begin = await findEdge(this.begin, -1n, seek);
      await seek(begin);
      if (this.node !== node) return;
      this.begin = begin;
      this.end = end;
      this.now = this.begin;
      this.slider.max = String(Number(end - this.begin) * 1e-9);
      this.setPaused(true);
    } catch (problem) {
      this.say(problem.message);
    } finally {
      this.isMeasuring = false;
    }
    this.showTime();
  }

  async ask() {
    try {
      if (this.connection.hasService(this.service('is_paused'))) this.setPaused((await this.connection.call(this.service('is_paused'))).paused);
    } catch {
      // The player was closed meanwhile.
    }
  }

  setPaused(isPaused) {
    this.isPaused = isPaused;
    setText(this.toggle, isPaused ? '▶ play' : '⏸ pause');
  }

  async pause(isPaused) {
    if (await this.robot.order(isPaused ? 'Pause' : 'Play', this.service(isPaused ? 'pause' : 'resume'), {})) this.setPaused(isPaused);
  }

  /** Follows the slider with one question at a time. */
  async scrub() {
    this.wanted = this.begin + BigInt(Math.round(this.slider.valueAsNumber * 1e9));
    this.now = this.wanted;
    this.showTime();
    if (this.isSeeking) return;
    this.isSeeking = true;
    try {
      while (this.wanted !== null) {
        const time = this.wanted;
        this.wanted = null;
        await this.connection.call(this.service('seek'), {time: timeOf(time)});
        if (this.isPaused && this.wanted === null) await this.glimpse(time);
      }
    } catch (problem) {
      this.say(problem.message);
    } finally {
      this.isSeeking = false;
    }
  }

  /** Plays a little, so that the other panels show what was there, and goes back. */
  async glimpse(time) {
    await this.connection.call(this.service('resume'));
    await new Promise((done) => setTimeout(done, GLIMPSE_MS));
    if (!this.isPaused) return; // the user pressed play meanwhile
    await this.connection.call(this.service('pause'));
    await this.connection.call(this.service('seek'), {time: timeOf(time)});
    this.now = time;
    this.showTime();
  }

  showTime() {
    const seconds = Number(this.now - this.begin) * 1e-9;
    const length = this.end ? Number(this.end - this.begin) * 1e-9 : seconds;
    if (document.activeElement !== this.slider || !this.isSeeking) this.slider.value = String(seconds);
    setText(this.where, `${seconds.toFixed(1)} of ${length.toFixed(1)} s, ${new Date(Number(this.now / 1_000_000n)).toLocaleString('en-GB')}`);
  }

  report() {
    return {
      ...super.report(),
      node: this.node,
      paused: this.isPaused,
      length: this.end ? Number(this.end - this.begin) * 1e-9 : null,
      position: this.begin ? Number(this.now - this.begin) * 1e-9 : null,
    };
  }
}
