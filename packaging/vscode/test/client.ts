/** A stub of the language client: keeps how it was started. */

/* eslint-disable @typescript-eslint/no-explicit-any */

export const clients: LanguageClient[] = [];

export class LanguageClient {
  state = 'new';
  constructor(
    readonly id: string,
    readonly name: string,
    readonly server: any,
    readonly options: any,
  ) {
    clients.push(this);
  }
  async start(): Promise<void> {
    if (this.server.command === 'missing') throw new Error('ENOENT');
    this.state = 'started';
  }
  async stop(): Promise<void> {
    this.state = 'stopped';
  }
}
