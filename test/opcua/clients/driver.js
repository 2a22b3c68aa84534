// An OPC UA client of another make, steered line by line by a test (see driver.py).
//
// One request of JSON on stdin, {id, do, …}, gets one answer, {id, answer} or {id, error}. What
// comes by itself is {news, …}. The end of stdin ends the client.
'use strict';
const readline = require('node:readline');
const ua = require('node-opcua-client');
const { OPCUACertificateManager } = require('node-opcua-certificate-manager');
const { plain, coerce } = require('./values');

const PREFIXES = { isa95: 'http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/' };

const options = JSON.parse(process.argv[2]);
const counted = {};
const subscriptions = [];
let client, session, names, alarms;

const tell = (line) => process.stdout.write(`${JSON.stringify(line)}\n`);

async function connect({ user, password, isEncrypted = true }) {
  const manager = new OPCUACertificateManager({
    rootFolder: options.pki,
    automaticallyAcceptUnknownCertificate: true,
  });
  await manager.initialize();
  client = ua.OPCUAClient.create({
    applicationName: 'ForeignClient',
    clientCertificateManager: manager,
    securityMode: isEncrypted ? ua.MessageSecurityMode.SignAndEncrypt : ua.MessageSecurityMode.None,
    securityPolicy: isEncrypted ? ua.SecurityPolicy.Basic256Sha256 : ua.SecurityPolicy.None,
    endpointMustExist: false,
    keepSessionAlive: true,
    requestedSessionTimeout: 60000,
    // For the first connection; one that is lost is then tried again for ever. Not so with 0.
    connectionStrategy: { initialDelay: 200, maxDelay: 1000, maxRetry: 1 },
  });
  client.on('send_request', (request) => {
    const name = request.constructor.name;
    counted[name] = (counted[name] || 0) + 1;
  });
  client.on('connection_lost', () => tell({ news: 'lost' }));
  client.on('connection_reestablished', () => tell({ news: 'back' }));
  await client.connect(options.endpoint);
  const anonymous = { type: ua.UserTokenType.Anonymous };
  session = await client.createSession(
    user ? { type: ua.UserTokenType.UserName, userName: user, password } : anonymous,
  );
  names = await session.readNamespaceArray();
  // Else the first values that have structures come in any order, while their types are asked for.
  await session.extractNamespaceDataType();
}

// A node: a whole id, or the string id of a node of the cell.
const node = (id) =>
  /^(ns=\d+;|[isgb]=)/.test(id) ? id : `ns=${names.indexOf(options.namespace)};s=${id}`;

// The field of an event: `Time`, or of another namespace, as in `isa95:JobOrder`, `cell:Hold`.
function field(text) {
  const [prefix, name] = text.split(':');
  const namespace = prefix === 'cell' ? options.namespace : PREFIXES[prefix];
  return name ? `${names.indexOf(namespace)}:${name}` : text;
}

async function childOf(parent, name) {
  const { references } = await session.browse({ nodeId: node(parent), resultMask: 63 });
  const found = references.find((one) => one.isForward && one.browseName.name === name);
  if (!found) throw new Error(`${parent} has no ${name}`);
  return found.nodeId;
}

const valueOf = (data) => ({
  value: plain(data.value),
  status: data.statusCode.name,
  stamp: data.sourceTimestamp,
});

const verbs = {
  connect,
  async read({ nodes }) {
    const wanted = nodes.map((id) => ({ nodeId: node(id), attributeId: ua.AttributeIds.Value }));
    return (await session.read(wanted)).map(valueOf);
  },
  async browse({ of }) {
    const { references } = await session.browse({ nodeId: node(of), resultMask: 63 });
    return references.filter((one) => one.isForward).map((one) => one.browseName.name);
  },
  async call({ on, method, args }) {
    const methodId = await childOf(on, method);
    const { inputArguments } = await session.getArgumentDefinition(methodId);
    const inputArgumentsGiven = [];
    for (const [at, argument] of inputArguments.entries())
      inputArgumentsGiven.push(await coerce(session, argument, args[at]));
    const done = await session.call({
      objectId: node(on),
      methodId,
      inputArguments: inputArgumentsGiven,
    });
    return { status: done.statusCode.name, outputs: (done.outputArguments || []).map(plain) };
  },
  async subscribe({ values = [], events = {} }) {
    const subscription = await session.createSubscription2({
      requestedPublishingInterval: 100,
      requestedLifetimeCount: 600,
      requestedMaxKeepAliveCount: 10,
      publishingEnabled: true,
    });
    subscriptions.push(subscription);
    for (const id of values) {
      const item = { nodeId: node(id), attributeId: ua.AttributeIds.Value };
      const monitored = await subscription.monitor(
        item,
        { samplingInterval: 0, queueSize: 1000 },
        ua.TimestampsToReturn.Both,
      );
      monitored.on('changed', (data) => tell({ news: 'value', of: id, ...valueOf(data) }));
    }
    for (const [id, fields] of Object.entries(events)) {
      const filter = ua.constructEventFilter(fields.map(field));
      const item = { nodeId: node(id), attributeId: ua.AttributeIds.EventNotifier };
      const monitored = await subscription.monitor(
        item,
        { samplingInterval: 0, queueSize: 1000, filter },
        ua.TimestampsToReturn.Both,
      );
      monitored.on('changed', (variants) => {
        const event = Object.fromEntries(fields.map((name, at) => [name.split(':').pop(), plain(variants[at])]));
        tell({ news: 'event', of: id, event });
      });
    }
    return subscription.subscriptionId;
  },
  async alarms() {
    alarms = await ua.installAlarmMonitoring(session);
    const told = (what) => (alarm) =>
      tell({ news: what, alarm: { id: alarm.conditionId.toString(), fields: fieldsOf(alarm) } });
    for (const what of ['newAlarm', 'alarmChanged', 'alarmDeleted']) alarms.on(what, told(what));
    return alarms.alarms().map(fieldsOf);
  },
  async acknowledge({ alarm, comment }) {
    const one = alarms.alarms().find((each) => each.conditionId.toString() === alarm);
    if (!one) throw new Error(`no alarm ${alarm}`);
    return (await session.acknowledgeCondition(one.conditionId, one.eventId, comment)).name;
  },
  async counted() {
    return counted;
  },
  async close() {
    if (session) await session.close();
    await client.disconnect();
    session = undefined;
  },
};

const fieldsOf = (alarm) =>
  Object.fromEntries(Object.entries(alarm.fields).map(([name, value]) => [name, plain(value)]));

async function answer(line) {
  const { id, do: verb, ...rest } = JSON.parse(line);
  try {
    tell({ id, answer: (await verbs[verb](rest)) ?? null });
  } catch (error) {
    tell({ id, error: error.message });
  }
}

// The library prints warnings to stdout: they go where they belong.
console.log = console.warn = console.info = console.error;
const lines = readline.createInterface({ input: process.stdin });
let last = Promise.resolve();
lines.on('line', (line) => (last = last.then(() => answer(line))));
lines.on('close', () => process.exit(0));
tell({ news: 'ready' });
