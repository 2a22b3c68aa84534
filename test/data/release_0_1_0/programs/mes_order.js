// One job order from an MES, with node-opcua: store and start it, hear of it, read what became of
// it, clear it.
//
//     npm install node-opcua-client
//     OPCUA_PASSWORD=… node mes_order.js opc.tcp://HOST:4840 USER ORDER SCRIPT QUANTITY
'use strict';
const ua = require('node-opcua-client');
const { OPCUACertificateManager } = require('node-opcua-certificate-manager');

const [endpoint, user, order, script, quantity] = process.argv.slice(2);
const JOB_CONTROL = 'http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/';

async function main() {
  // The certificate of this client is made in ./pki at the first start, and stays the same.
  const certificates = new OPCUACertificateManager({
    rootFolder: process.env.OPCUA_PKI || 'pki',
    automaticallyAcceptUnknownCertificate: true, // better: trust that of the server by hand
  });
  await certificates.initialize();
  const client = ua.OPCUAClient.create({
    applicationName: 'MES',
    clientCertificateManager: certificates,
    securityMode: ua.MessageSecurityMode.SignAndEncrypt,
    securityPolicy: ua.SecurityPolicy.Basic256Sha256,
    endpointMustExist: false,
    connectionStrategy: { maxRetry: 1 }, // with 0 it would never connect again
  });
  await client.connect(endpoint);
  try {
    const session = await client.createSession({
      type: ua.UserTokenType.UserName,
      userName: user,
      password: process.env.OPCUA_PASSWORD,
    });
    await run(session);
    await session.close();
  } finally {
    await client.disconnect();
  }
}

async function run(session) {
  // Load the structures first: else the first events come in any order, while they are asked for.
  await session.extractNamespaceDataType();
  const names = await session.readNamespaceArray();
  const cell = names.findIndex((name) => name.startsWith('urn:bt_orchestrator:cell:'));
  const standard = names.indexOf(JOB_CONTROL);
  const node = (path) => `ns=${cell};s=${path}`;

  // Hear of the order before it is stored: no event is missed.
  const subscription = await session.createSubscription2({
    requestedPublishingInterval: 100,
    requestedLifetimeCount: 600,
    requestedMaxKeepAliveCount: 10,
    publishingEnabled: true,
  });
  const filter = ua.constructEventFilter(['JobOrder', 'JobState'].map((name) => `${standard}:${name}`));
  const events = await subscription.monitor(
    { nodeId: node('JobOrderResults'), attributeId: ua.AttributeIds.EventNotifier },
    { samplingInterval: 0, queueSize: 1000, filter },
    ua.TimestampsToReturn.Both,
  );
  const ended = new Promise((resolve) =>
    events.on('changed', ([jobOrder, jobState]) => {
      if (jobOrder.value?.jobOrderID !== order) return;
      const state = jobState.value.map((one) => one.stateText.text).join('/');
      console.log(`${order}: ${state}`);
      if (state === 'Ended' || state === 'Aborted') resolve();
    }),
  );

  const call = async (on, method, ...inputArguments) => {
    const objectId = node(on);
    const methodId = node(`${on}/${method}`);
    const done = await session.call({ objectId, methodId, inputArguments });
    if (!done.outputArguments?.length) throw new Error(`${method}: ${done.statusCode.name}`);
    const outputs = done.outputArguments.map((one) => one.value);
    // ReturnStatus is the last one, 64 bits in two numbers: 1 is done, all others say why not.
    const [high, low] = outputs.at(-1);
    console.log(`${method}: ${high * 2 ** 32 + low}`);
    if (low !== 1) throw new Error(`${method} was refused; see docs/mes.md for the number`);
    return outputs;
  };

  const jobOrderType = ua.coerceNodeId(`ns=${standard};i=3008`);
  const jobOrder = await session.constructExtensionObject(jobOrderType, {
    jobOrderID: order,
    workMasterID: [{ ID: script }],
    jobOrderParameters: [
      { ID: 'RunsPlanned', value: { dataType: 'UInt32', value: Number(quantity) } },
    ],
  });
  const comment = { dataType: 'LocalizedText', arrayType: 'Array', value: [{ text: 'an example' }] };
  const id = { dataType: 'String', value: order };
  await call(
    'JobOrderControl',
    'StoreAndStart',
    { dataType: 'ExtensionObject', value: jobOrder },
    comment,
  );
  await ended;

  const [response] = await call('JobOrderResults', 'RequestJobResponseByJobOrderID', id);
  for (const { ID, value } of response.jobResponseData)
    if (['GoodQuantity', 'ScrapQuantity'].includes(ID)) console.log(`${ID}: ${value.value}`);
  await call('JobOrderControl', 'Clear', id, comment);
}

main().catch((error) => {
  console.error(error.message);
  process.exit(1);
});
