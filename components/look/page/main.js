// SPDX-License-Identifier: Apache-2.0
// Starts the page: the connection, the bar with the emergency stop, and the panels.
import {Connection} from './connection.js';
import {button, setText} from './dom.js';
import {CameraPanel} from './panels/camera.js';
import {ComponentsPanel} from './panels/components.js';
import {DrivePanel} from './panels/drive.js';
import {FaultsPanel} from './panels/faults.js';
import {GraphPanel} from './panels/graph.js';
import {LogsPanel} from './panels/logs.js';
import {ParametersPanel} from './panels/parameters.js';
import {PlotsPanel} from './panels/plots.js';
import {RecordPanel} from './panels/record.js';
import {ReplayPanel} from './panels/replay.js';
import {StreamsPanel} from './panels/streams.js';
import {WorldPanel} from './panels/world.js';
import {Robot} from './robot.js';
import {Tabs} from './tabs.js';

const WORDS_MS = 8000;
const KINDS = [
  WorldPanel,
  CameraPanel,
  DrivePanel,
  ComponentsPanel,
  PlotsPanel,
  StreamsPanel,
  LogsPanel,
  FaultsPanel,
  GraphPanel,
  ParametersPanel,
  RecordPanel,
  ReplayPanel,
];
const byId = (id) => document.getElementById(id);

/** The token comes behind # in the link, so that no server and no history keeps it. */
function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  if (given) {
    sessionStorage.setItem('token', given);
    history.replaceState(null, '', location.pathname);
  }
  return sessionStorage.getItem('token') ?? '';
}

function showState(robot) {
  const {connection} = robot;
  const state = byId('state');
  const rights = {operate: 'connected', view: 'connected, may only look'};
  let text = rights[robot.right] ?? 'connecting ...';
  if (connection.state === 'lost') {
    const seconds = Math.round(connection.retryMs / 100) / 10;
    const hint = connection.info ? '' : ' Is the link the one that `nacelle look` prints?';
    text = `NOT CONNECTED. What is shown is old. Trying again in ${seconds} s.${hint}`;
  }
  setText(state, text);
  document.body.className = connection.state;
  byId('retry').hidden = connection.state !== 'lost';
  setText(byId('name'), robot.name || 'Nacelle');
  document.title = robot.name ? `${robot.name}: Nacelle` : 'Nacelle';
}

function listenToStop(robot) {
  const stop = byId('stop');
  const release = byId('release');
  stop.title = 'Emergency stop: the wheels stop at once and stay stopped.';
  stop.addEventListener('click', () => robot.stop());
  release.addEventListener('click', () => robot.releaseStops());
  const show = () => {
    const isSet = robot.stops.length > 0;
    document.documentElement.classList.toggle('stopped', isSet);
    setText(stop, isSet ? 'STOPPED' : 'STOP');
    stop.setAttribute('aria-pressed', String(isSet));
    release.hidden = !isSet;
    release.disabled = !robot.mayOperate;
    release.title = robot.whyNot || `Release ${robot.stops.join(', ')}`;
  };
  robot.on('stops', show);
  robot.on('right', show);
  show();
}

function listenToWords(robot) {
  const words = byId('words');
  let timer;
  robot.on('words', (text, isError) => {
    words.textContent = text;
    words.className = isError ? 'bad' : '';
    words.hidden = false;
    clearTimeout(timer);
    timer = setTimeout(
      () => {
        words.hidden = true;
      },
      isError ? 2 * WORDS_MS : WORDS_MS,
    );
  });
  words.addEventListener('click', () => {
    words.hidden = true;
  });
}

function main() {
  const token = takeToken();
  const scheme = location.protocol === 'https:' ? 'wss' : 'ws';
  const connection = new Connection(`${scheme}://${location.host}/?token=${encodeURIComponent(token)}`);
  const robot = new Robot(connection);
  connection.on('state', () => showState(robot));
  robot.on('right', () => showState(robot));
  byId('retry').addEventListener('click', () => connection.reconnect());
  window.addEventListener('online', () => connection.reconnect());
  listenToStop(robot);
  listenToWords(robot);
  const panels = KINDS.map((Kind) => new Kind(robot));
  byId('panels').append(...panels.map(({root}) => root));
  const tabs = new Tabs(panels, byId('tabs'), button);
  document.addEventListener('visibilitychange', () => {
    robot.isAwake = document.visibilityState === 'visible';
    tabs.apply();
  });
  tabs.apply();
  // For tests, and for the curious.
  window.nacelle = {
    robot,
    tabs,
    get panels() {
      return Object.fromEntries(panels.map((panel) => [panel.name, panel.report()]));
    },
  };
  if (token === '') {
    setText(byId('state'), 'This address has no token. Open the link that `nacelle look` prints.');
    document.body.className = 'lost';
    return;
  }
  connection.connect();
}

main();
