// SPDX-License-Identifier: Apache-2.0
import {CommandSender, commandTopics} from '../command.js';
import {element, labelled, setText} from '../dom.js';
import {Joystick} from '../joystick.js';
import {Panel} from '../panel.js';
import {ofType} from '../scene.js';

/** A joystick with a dead-man grip. */
export class DrivePanel extends Panel {
  constructor(robot) {
    super(robot, 'drive', 'Drive');
    this.sender = new CommandSender(robot);
    this.stick = new Joystick({
      grip: () => this.sender.grip(),
      move: (x, y) => this.sender.set(y * this.linear.valueAsNumber, -x * this.angular.valueAsNumber),
      release: () => this.sender.release(),
    });
    this.sender.onRelease = (why) => {
      this.stick.letGo();
      this.why = why;
      this.describe();
    };
    const range = (max, value, text) =>
      element('input', {type: 'range', min: 0.05, max, step: 0.05, value, 'aria-label': text, oninput: () => this.describe()});
    this.linear = range(1, 0.3, 'Fastest speed in metres per second');
    this.angular = range(3, 1, 'Fastest turn in radians per second');
    this.linearText = element('output');
    this.angularText = element('output');
    this.topics = element('select', {'aria-label': 'Topic of commands', onchange: () => this.choose(this.topics.value)});
    this.topics.append(element('option', {value: ''}, 'no topic'));
    this.speed = element('p', {class: 'facts'});
    this.tools.append(this.topics);
    this.body.append(
      this.stick.root,
      element('div', {class: 'sliders'}, labelled('speed', this.linear), this.linearText, labelled('turn', this.angular), this.angularText),
      this.speed,
    );
    this.twist = null;
    robot.on('right', () => this.describe());
    this.describe();
  }

  start() {
    this.ends.push(this.connection.watchGraph());
    this.on(this.connection, 'graph', () => this.list());
    this.on(this.connection, 'channels', () => this.list());
    this.on(this.robot, 'stops', () => this.describe());
    this.subscribe(
      (channels) => ofType(channels, 'nav_msgs/msg/Odometry', ['/odom', '/odometry/filtered'])[0],
      (message) => {
        this.twist = message.twist.twist;
        this.sender.isHeard = true;
      },
    );
    this.every(200, () => this.describe());
    this.list();
  }

  stop() {
    this.stick.letGo();
    this.sender.release();
    this.sender.isHeard = false;
    this.twist = null;
    super.stop();
  }

  list() {
    const found = commandTopics(this.connection);
    if (
      found.join() !==
      [...this.topics.options]
        .map(({value}) => value)
        .filter(Boolean)
        .join()
    ) {
      this.topics.replaceChildren(...(found.length > 0 ? found : ['']).map((topic) => element('option', {value: topic}, topic || 'no topic')));
    }
    if (!found.includes(this.sender.topic)) this.choose(found[0] ?? '');
    this.topics.value = this.sender.topic;
  }

  choose(topic) {
    this.stick.letGo();
    this.sender.release();
    if (this.sender.topic !== '') this.connection.unpublish(this.sender.topic);
    this.sender.topic = topic;
  }

  describe() {
    setText(this.linearText, `${this.linear.value} m/s`);
    setText(this.angularText, `${this.angular.value} rad/s`);
    const whyNot = this.robot.whyNot || (this.robot.stops.length > 0 ? 'The emergency stop is set: the wheels stay stopped.' : (this.why ?? ''));
    this.say(whyNot || 'Hold the stick to drive. Letting go stops the robot.');
    this.stick.root.setAttribute('aria-disabled', String(!this.robot.mayOperate));
    if (this.sender.isHeld) this.why = '';
    const {twist} = this;
    setText(
      this.speed,
      twist ? `now ${twist.linear.x.toFixed(2)} m/s, ${twist.angular.z.toFixed(2)} rad/s${this.sender.isHeld ? ', driving' : ''}` : '',
    );
  }

  touch() {
    this.lastData = performance.now();
  } // the note stays

  report() {
    const shown = super.report();
    return {
      ...shown,
      live: shown.live && this.sender.topic !== '',
      topic: this.sender.topic,
      held: this.sender.isHeld,
      speed: this.twist ? this.twist.linear.x : null,
    };
  }
}
