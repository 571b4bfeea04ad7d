// Required before a suite that knows only a router on its own computer: its connections go to ADS_SERVER.
const { Socket } = require("node:net");

const connect = Socket.prototype.connect;
Socket.prototype.connect = function (...given) {
  const options = Array.isArray(given[0]) ? given[0][0] : given[0];
  if (options?.port === 48898) options.host = process.env.ADS_SERVER;
  return connect.apply(this, given);
};
